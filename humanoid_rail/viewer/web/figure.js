// A robot that moves: its links, the frames of its joints, its hands, and the lines to what it comes closest to.
"use strict";

const AXES = 0.18; // the axes of frames are this long, m; scaled with the robot
const SHORTEST = 1e-4; // a line has at least this length: nothing without length can be turned, m

function makeFigure(viewer, page, motion, number) {
  const { THREE } = MeshCat, width = page.jointNames.length;
  const moments = unpacked(motion.t), q = unpacked(motion.q);
  const find = (...path) => viewer.scene_tree.find(["meshcat", "world", `motion${number}`, ...path]).object;
  const nodes = ["universe", ...page.joints.map(joint => joint.node)];
  const trees = ["robot", "bodies"].map(tree => nodes.map(name => find(tree, name)));
  const axes = find("axes");
  axes.visible = false;
  nodes.slice(1).forEach(() => {
    const cross = new THREE.AxesHelper(AXES * page.scale);
    cross.material.depthTest = false;
    cross.material.transparent = true;
    cross.renderOrder = 5;
    axes.add(cross);
  });
  if (number > 0) {
    find("robot").traverse(node => {
      const look = node.material; // edges of boxes are lines without opacity
      if (look) Object.assign(look, { transparent: true, depthWrite: false, opacity: Math.min(look.opacity, 0.5) });
    });
  }
  const lines = Object.entries(motion.closest).map(([kind, pairs]) => {
    const [line, one, two] = ["line", "one", "two"].map(part => find("closest", kind, part));
    return { line, one, two, points: unpacked(pairs.points) };
  });
  const up = new THREE.Vector3(0, 1, 0);

  const put = (node, matrix) => node.matrix.fromArray(matrix).decompose(node.position, node.quaternion, node.scale);

  // What hands can hold, each where the last part of its way that has begun says.
  const objects = (motion.objects || []).map(({ node, parts }) => ({ node: find("objects", node), parts }));

  const figure = {
    motion, moments,
    hands: page.hands.map(() => new THREE.Vector3()), // where they are, in the base frame, m
    joints: nodes.map(() => new THREE.Vector3()),
    find,
    axes,

    configuration(t) {
      return rowAt(q, width, momentAt(moments, t));
    },
    show(t) {
      const at = placements(page.joints, figure.configuration(t));
      at.forEach((matrix, i) => {
        for (const nodes of trees) put(nodes[i], matrix);
        figure.joints[i].setFromMatrixPosition({ elements: matrix });
        if (i > 0) put(axes.children[i - 1], matrix);
      });
      for (const { node, parts } of objects) {
        const { joint, placement } = parts.filter(part => part.t <= t).pop() || parts[0];
        put(node, times(at[joint], placement));
      }
      page.hands.forEach((hand, i) => {
        const matrix = new THREE.Matrix4().fromArray(at[hand.joint]);
        figure.hands[i].fromArray(hand.offset).applyMatrix4(matrix);
      });
      const moment = momentAt(moments, t);
      for (const { line, one, two, points } of lines) {
        const ends = rowAt(points, 6, moment);
        one.position.fromArray(ends, 0);
        two.position.fromArray(ends, 3);
        const along = two.position.clone().sub(one.position), length = Math.max(along.length(), SHORTEST);
        line.position.copy(one.position).lerp(two.position, 0.5);
        line.quaternion.setFromUnitVectors(up, along.divideScalar(length).lengthSq() > 0.5 ? along : up);
        line.scale.set(1, length, 1);
      }
    },
  };
  return figure;
}
