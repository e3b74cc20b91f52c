// What a plan that failed shows: the nearest miss, what blocks it, and the panel that says why.
"use strict";

function makeMiss(viewer, page, figures, labels) {
  const panel = document.getElementById("why");
  if (!panel) return null;
  const nodes = [];
  panel.addEventListener("click", event => {
    if (event.target.tagName === "H2") panel.classList.toggle("folded");
  });
  page.motions.forEach(({ miss }, number) => {
    if (!miss) return;
    nodes.push(figures[number].find("miss"));
    for (const { text, place } of miss.labels) labels.add("miss", text, () => place);
  });
  return {
    set(value) {
      panel.hidden = !value;
      for (const node of nodes) node.visible = value;
      labels.set("miss", value);
      viewer.set_dirty();
    },
  };
}
