// Names in the picture: of obstacles and hands, and the numbers of targets. They are text, whatever is in them.
"use strict";

const MOST_NAMES = 40; // of more obstacles, those nearest to the hands are named

function makeLabels(viewer, page, figures, obstacles, inView) {
  const layer = document.getElementById("labels"), shown = { names: false, steps: true, miss: false };
  const labels = [];

  function add(kind, text, place, colour) {
    const element = Object.assign(document.createElement("span"), { className: kind, textContent: text, hidden: true });
    if (colour) element.style.setProperty("--colour", colour);
    layer.append(element);
    labels.push({ kind, element, place });
  }
  const colours = Object.fromEntries(page.hands.map(hand => [hand.name, hand.colour]));
  // Steps that have a hand at the same place have one mark there.
  const marked = new Map(page.targets.map(target => [`${target.hand} ${target.steps}`, target]));
  for (const { steps, hand, position } of marked.values())
    add("steps", page.steps > 1 ? steps : hand[0].toUpperCase(), () => position, colours[hand]);
  figures.forEach(figure => page.hands.forEach((hand, i) =>
    add("names", hand.name, () => figure.hands[i].toArray(), hand.colour)));

  // An obstacle of several pieces has one name.
  const places = new Map();
  for (const { node, bodies } of obstacles.groups)
    for (const { owners, balls } of bodies)
      owners.forEach((owner, i) => {
        if (!places.has(owner)) places.set(owner, { node, at: [...balls.slice(4 * i, 4 * i + 3)] });
      });
  const centre = owner => {
    const { node, at } = places.get(owner);
    return [at[0] + node.position.x, at[1] + node.position.y, at[2] + node.position.z];
  };
  let named = null;
  function nameObstacles() {
    const distance = owner => {
      const [x, y, z] = centre(owner);
      return Math.min(...figures[0].hands.map(hand => Math.hypot(hand.x - x, hand.y - y, hand.z - z)));
    };
    const near = [...places.keys()].map(owner => [distance(owner), owner]).sort((a, b) => a[0] - b[0]);
    named = near.slice(0, MOST_NAMES).map(([, owner]) => owner);
    for (const owner of named) add("names", page.obstacles[owner], () => centre(owner));
  }

  return {
    add,
    set(kind, value) {
      shown[kind] = value;
      if (kind === "names" && value && !named) nameObstacles();
    },
    update() {
      const { width, height } = layer.getBoundingClientRect();
      for (const { kind, element, place } of labels) {
        element.hidden = !shown[kind];
        if (!shown[kind]) continue;
        const at = inView(place()).project(viewer.camera);
        element.hidden = at.z > 1 || Math.abs(at.x) > 1 || Math.abs(at.y) > 1;
        const x = (at.x + 1) / 2 * width, y = (1 - at.y) / 2 * height;
        element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      }
    },
  };
}
