// Obstacles: those that move, the edges of boxes, and those that fade where they stand between camera and robot.
"use strict";

const FADED = 0.12, FADED_EDGE = 0.4; // how much is left of what has faded
const FADE_TIME = 0.15; // s
const OFTEN = 60, SELDOM = 250; // rays are cast again after so long, ms: seldom among very many bodies
const MANY = 4000;

// Let each body of a material have an opacity of its own: the attribute `alpha`.
function withAlpha(material) {
  const own = material.clone();
  own.transparent = true;
  own.depthWrite = false;
  own.onBeforeCompile = shader => {
    shader.vertexShader = shader.vertexShader
      .replace("void main() {", "attribute float alpha;\nvarying float ownAlpha;\nvoid main() {\nownAlpha = alpha;");
    shader.fragmentShader = shader.fragmentShader
      .replace("void main() {", "varying float ownAlpha;\nvoid main() {")
      .replace("#include <color_fragment>", "#include <color_fragment>\ndiffuseColor.a *= ownAlpha;");
  };
  return own;
}

// The edges of the box from -1/2 to 1/2, as triangles without area, which a wireframe draws as lines.
function boxEdges() {
  const { THREE } = MeshCat, corners = [], index = [];
  for (let i = 0; i < 8; i++) {
    corners.push((i & 4 ? 1 : -1) / 2, (i & 2 ? 1 : -1) / 2, (i & 1 ? 1 : -1) / 2);
    for (const step of [1, 2, 4]) if (!(i & step)) index.push(i, i + step, i);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
  geometry.setIndex(index);
  return geometry;
}

// Bodies of one geometry, of which some are drawn as they are and the others, in a mesh of their own, faded.
function makeBodies(mesh) {
  const { THREE } = MeshCat, count = mesh.count, matrices = mesh.instanceMatrix.array.slice();
  mesh.geometry.computeBoundingBox();
  const { min, max } = mesh.geometry.boundingBox;
  const inverses = new Float32Array(12 * count), balls = new Float32Array(4 * count);
  const matrix = new THREE.Matrix4(), ball = new THREE.Sphere();
  mesh.geometry.computeBoundingSphere();
  for (let i = 0; i < count; i++) {
    matrix.fromArray(matrices, 16 * i);
    ball.copy(mesh.geometry.boundingSphere).applyMatrix4(matrix);
    balls.set([ball.center.x, ball.center.y, ball.center.z, ball.radius], 4 * i);
    const e = matrix.invert().elements;
    inverses.set([e[0], e[1], e[2], e[4], e[5], e[6], e[8], e[9], e[10], e[12], e[13], e[14]], 12 * i);
  }
  const alphas = new THREE.InstancedBufferAttribute(new Float32Array(count), 1);
  const edgeAlphas = new THREE.InstancedBufferAttribute(new Float32Array(count), 1);
  const drawn = [mesh], faded = [];

  const add = (geometry, material, alpha, order, list) => {
    const own = new THREE.InstancedMesh(alpha ? geometry.clone() : geometry, alpha ? withAlpha(material) : material, count);
    if (alpha) own.geometry.setAttribute("alpha", alpha);
    own.instanceMatrix = (list[0] || own).instanceMatrix;
    own.frustumCulled = false;
    own.renderOrder = order;
    mesh.parent.add(own);
    list.push(own);
  };
  Object.assign(mesh.material, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  add(mesh.geometry, mesh.material, alphas, 1, faded);
  if (mesh.geometry.type === "BoxGeometry" && !mesh.material.transparent) {
    const dark = mesh.material.color.clone().multiplyScalar(0.72);
    const line = new THREE.MeshBasicMaterial({ color: dark, wireframe: true });
    add(boxEdges(), line, null, 0, drawn);
    add(boxEdges(), line, edgeAlphas, 2, faded);
  }
  for (const each of faded) each.count = 0;

  const opacity = new Float32Array(count).fill(1), goal = new Float32Array(count).fill(1);
  const changing = new Set(); // those that are not, or not to be, wholly there

  // Return whether the body i is between two points, given as (6,) numbers in its group.
  function between(i, [ax, ay, az, bx, by, bz]) {
    const x = balls[4 * i] - ax, y = balls[4 * i + 1] - ay, z = balls[4 * i + 2] - az, r = balls[4 * i + 3];
    const dx = bx - ax, dy = by - ay, dz = bz - az;
    const along = Math.min(Math.max((x * dx + y * dy + z * dz) / (dx * dx + dy * dy + dz * dz), 0), 1);
    if ((x - along * dx) ** 2 + (y - along * dy) ** 2 + (z - along * dz) ** 2 > r * r) return false;
    const m = inverses, k = 12 * i;
    let enter = 0, leave = 1;
    for (let axis = 0; axis < 3; axis++) {
      const from = m[k + axis] * ax + m[k + 3 + axis] * ay + m[k + 6 + axis] * az + m[k + 9 + axis];
      const by_ = m[k + axis] * dx + m[k + 3 + axis] * dy + m[k + 6 + axis] * dz;
      const low = min.getComponent(axis), high = max.getComponent(axis);
      if (Math.abs(by_) < 1e-12) {
        if (from < low || from > high) return false;
        continue;
      }
      const one = (low - from) / by_, two = (high - from) / by_;
      enter = Math.max(enter, Math.min(one, two));
      leave = Math.min(leave, Math.max(one, two));
    }
    return enter <= leave;
  }

  return {
    count, balls,
    owners: mesh.userData.owners,
    get isSettled() { return [...changing].every(i => opacity[i] === goal[i]); },
    // Choose which bodies fade: those between the ends of any of the rays.
    aim(rays) {
      for (let i = 0; i < count; i++) {
        goal[i] = rays.some(ray => between(i, ray)) ? 0 : 1;
        if (goal[i] !== opacity[i]) changing.add(i);
      }
    },
    // Let them fade for some seconds; return whether anything is to be drawn anew.
    fade(passed) {
      const moving = [...changing].filter(i => opacity[i] !== goal[i]);
      if (!moving.length) return false;
      const by = passed / FADE_TIME;
      for (const i of moving) {
        opacity[i] += Math.min(Math.max(goal[i] - opacity[i], -by), by);
        if (opacity[i] === 1 && goal[i] === 1) changing.delete(i);
      }
      const solid = mesh.instanceMatrix, ghost = faded[0].instanceMatrix;
      let solids = 0, ghosts = 0;
      for (let i = 0; i < count; i++) {
        const from = matrices.subarray(16 * i, 16 * i + 16);
        if (opacity[i] === 1) solid.array.set(from, 16 * solids++);
        else {
          alphas.array[ghosts] = FADED + (1 - FADED) * opacity[i];
          edgeAlphas.array[ghosts] = FADED_EDGE + (1 - FADED_EDGE) * opacity[i];
          ghost.array.set(from, 16 * ghosts++);
        }
      }
      for (const attribute of [solid, ghost, alphas, edgeAlphas]) attribute.needsUpdate = true;
      for (const each of drawn) each.count = solids;
      for (const each of faded) each.count = ghosts;
      return true;
    },
  };
}

function makeObstacles(viewer, page) {
  const root = viewer.scene_tree.find(["meshcat", "world", "obstacles"]).object, groups = [];
  root.traverse(node => {
    if (!/^together\d+$/.test(node.name)) return;
    const meshes = node.children.filter(child => child.isInstancedMesh && !child.material.transparent);
    groups.push({ node, velocity: page.velocities[node.name], bodies: meshes.map(makeBodies) });
  });
  const all = groups.flatMap(group => group.bodies.map(bodies => ({ group, bodies })));
  const count = all.reduce((sum, { bodies }) => sum + bodies.count, 0);
  let isFading = true, isStale = true, cast = 0, last = 0;

  return {
    count, groups,
    // Whether all that is to fade has.
    get isSettled() { return !isStale && all.every(({ bodies }) => bodies.isSettled); },
    setFading(value) {
      isFading = value;
      isStale = true;
    },
    show(t) {
      for (const { node, velocity } of groups) if (velocity) node.position.fromArray(velocity).multiplyScalar(t);
      isStale = true;
    },
    stale() { isStale = true; },
    // Fade what is between the camera and points, in the base frame; return whether anything is to be drawn anew.
    update(now, camera, points) {
      const passed = Math.min((now - last) / 1000, 0.1);
      last = now;
      if (isStale && now - cast > (count > MANY ? SELDOM : OFTEN)) {
        isStale = false;
        cast = now;
        for (const { group, bodies } of all) {
          const { x, y, z } = group.node.position;
          const ray = p => [p.x - x, p.y - y, p.z - z, camera.x - x, camera.y - y, camera.z - z];
          bodies.aim(isFading ? points.map(ray) : []);
        }
      }
      let isChanged = false;
      for (const { bodies } of all) isChanged = bodies.fade(passed) || isChanged;
      return isChanged;
    },
  };
}
