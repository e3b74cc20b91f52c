// The page of a robot: sliders for its joints, where its links are, and which of its bodies touch.
"use strict";

const robot = JSON.parse(document.getElementById("page-data").textContent);
const COLOURS = { free: [0x4c8dd6, 0.3], near: [0xf07f1b, 0.6], touching: [0xd7191c, 0.8] };
let q = [...robot.initial];

// Return the bodies where they are.
function placedBodies(q) {
  const at = placements(robot.joints, q);
  return robot.bodies.map(body => {
    const m = at[body.joint];
    const turned = p => [0, 1, 2].map(i => m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2]);
    const placed = p => turned(p).map((x, i) => x + m[12 + i]);
    return { ...body, points: body.points.map(placed), axis: turned(body.axis), middle: placed(body.middle) };
  });
}

// Return the distances of pairs of bodies [i, j, m] in m; infinite where they are surely farther than that.
function distances(q, pairs) {
  const bodies = placedBodies(q);
  return pairs.map(([i, j, most]) => {
    const a = bodies[i], b = bodies[j];
    const apart = Math.hypot(...minus(a.middle, b.middle)) - a.extent - b.extent;
    return apart > most ? Infinity : convexDistance(a, b);
  });
}

function inScene(...path) {
  return viewer.scene_tree.find(["meshcat", "world", ...path]).object;
}

function paint(body, [colour, opacity]) {
  inScene("bodies", robot.nodes[body.joint], body.node).traverse(node => {
    if (node.material) {
      node.material.color.setHex(colour);
      node.material.opacity = opacity;
    }
  });
}

function list(id, lines) {
  const items = lines.map(line => Object.assign(document.createElement("li"), { textContent: line }));
  document.getElementById(id).replaceChildren(...items);
  document.getElementById(`${id}-count`).textContent = lines.length;
}

function showContacts() {
  const found = distances(q, [...robot.checked, ...robot.unchecked]), states = robot.bodies.map(() => "free");
  const said = { touching: new Set(), near: new Set() };
  robot.checked.forEach(([i, j, least], k) => {
    if (found[k] > least) return;
    const state = found[k] <= 0 ? "touching" : "near";
    for (const body of [i, j]) if (states[body] !== "touching") states[body] = state;
    said[state].add(`${robot.bodies[i].link} – ${robot.bodies[j].link}`);
  });
  robot.bodies.forEach((body, i) => paint(body, COLOURS[states[i]]));
  for (const pair of said.touching) said.near.delete(pair);
  list("touching", [...said.touching]);
  list("near", [...said.near]);
  const unchecked = new Set();
  robot.unchecked.forEach(([, , , reason], k) => {
    if (found[robot.checked.length + k] <= 0) unchecked.add(robot.reasons[reason]);
  });
  list("unchecked", [...unchecked]);
}

function show() {
  placements(robot.joints, q).forEach((at, i) => {
    for (const tree of ["robot", "bodies"]) {
      const node = inScene(tree, robot.nodes[i]);
      node.matrix.fromArray(at).decompose(node.position, node.quaternion, node.scale);
    }
  });
  robot.sliders.forEach(({ unit }, i) => {
    document.getElementById(`slider-${i}`).value = q[i];
    const degrees = unit === "rad" ? ` (${(q[i] * 180 / Math.PI).toFixed(0)}°)` : "";
    document.getElementById(`value-${i}`).textContent = `${q[i].toFixed(3)} ${unit}${degrees}`;
  });
  const positions = robot.sliders.map(({ name }, i) => `${name}: ${q[i].toFixed(4)}`);
  document.getElementById("posture").value = `{${positions.join(", ")}}`;
  showContacts();
  viewer.set_dirty();
}

function setPosture(positions) {
  q = [...positions];
  show();
}

function toggle(tree) {
  const box = document.getElementById(`show-${tree}`);
  inScene(tree).visible = box.checked;
  viewer.set_dirty();
}

document.addEventListener("drawn", () => {
  viewer.gui.domElement.remove();
  robot.sliders.forEach((_, i) => {
    document.getElementById(`slider-${i}`).addEventListener("input", event => {
      q[i] = Number(event.target.value);
      show();
    });
  });
  for (const button of document.querySelectorAll("button[data-posture]"))
    button.addEventListener("click", () => setPosture(robot.postures[button.dataset.posture]));
  const keys = { m: "robot", b: "bodies" };
  for (const tree of Object.values(keys))
    document.getElementById(`show-${tree}`).addEventListener("change", () => toggle(tree));
  document.addEventListener("keydown", event => {
    const tree = keys[event.key.toLowerCase()];
    if (!tree || event.ctrlKey || event.metaKey || event.target.tagName === "TEXTAREA") return;
    document.getElementById(`show-${tree}`).click();
  });
  show();
  window.isReady = true;
});
