// The page that plays motions back: its parts, and how they are connected.
"use strict";

document.addEventListener("drawn", () => {
  const page = JSON.parse(document.getElementById("page-data").textContent);
  const pane = document.getElementById("meshcat-pane"), { THREE } = MeshCat;
  viewer.gui.domElement.remove();

  // meshcat takes the height of the window for its own.
  viewer.set_3d_pane_size = () => {
    const { clientWidth, clientHeight } = pane;
    viewer.camera.aspect = clientWidth / Math.max(clientHeight, 1);
    viewer.camera.updateProjectionMatrix();
    viewer.renderer.setSize(clientWidth, clientHeight);
    viewer.set_dirty();
  };
  viewer.set_3d_pane_size();

  const clock = makeClock(Math.max(...page.motions.map(motion => motion.duration)));
  const camera = makeCamera(viewer, pane, page.view);
  const stage = makeStage(viewer, camera.middle, camera.radius, page.floor, page.scale);
  const figures = page.motions.map((motion, number) => makeFigure(viewer, page, motion, number));
  const obstacles = makeObstacles(viewer, page);
  stage.castShadows(obstacles.count);
  const labels = makeLabels(viewer, page, figures, obstacles, camera.inView);
  const miss = makeMiss(viewer, page, figures, labels);
  const plots = makePlots(page, clock), timeline = makeTimeline(page, clock);

  const points = () => figures.flatMap(figure => [...figure.joints.slice(1), ...figure.hands]);
  const centre = () => {
    const sum = new THREE.Vector3();
    for (const hand of figures[0].hands) sum.add(hand);
    return camera.inView(sum.divideScalar(figures[0].hands.length).toArray());
  };

  const parts = name => value => {
    for (const figure of figures) figure.find(name).visible = value;
    viewer.set_dirty();
  };
  const views = {
    follow: {
      isOn: false,
      turn: value => {
        if (value) {
          camera.approach(centre());
          camera.follow(centre());
        } else if (views.follow.wasOn) {
          camera.follow(null);
          camera.fit();
        }
        views.follow.wasOn = value;
      },
    },
    reset: { isOn: false, turn: () => { if (!views.follow.isOn) camera.fit(); } },
    fade: { isOn: true, turn: obstacles.setFading },
    robot: { isOn: true, turn: parts("robot") },
    bodies: { isOn: false, turn: parts("bodies") },
    axes: { isOn: false, turn: value => { for (const { axes } of figures) axes.visible = value; viewer.set_dirty(); } },
    closest: { isOn: true, turn: parts("closest") },
    traces: { isOn: true, turn: parts("traces") },
    names: { isOn: false, turn: value => { labels.set("names", value); viewer.set_dirty(); } },
    steps: { isOn: true, turn: value => { labels.set("steps", value); viewer.set_dirty(); } },
    plots: { isOn: true, turn: value => { document.getElementById("plots").hidden = !value; } },
  };

  if (miss) views.why = { isOn: true, turn: miss.set };

  clock.onChange(t => {
    for (const figure of figures) figure.show(t);
    obstacles.show(t);
    if (views.follow.isOn) camera.follow(centre());
    viewer.set_dirty();
  });
  camera.onMove(obstacles.stale);
  makeKeys(clock, timeline, views);

  const render = viewer.render.bind(viewer);
  viewer.render = () => {
    stage.update(viewer.camera, viewer.controls.target);
    render();
    labels.update();
  };
  new ResizeObserver(() => {
    viewer.set_3d_pane_size();
    camera.refit();
  }).observe(pane);
  document.getElementById("caption").addEventListener("click", event => {
    event.currentTarget.classList.toggle("open");
  });

  function frame(now) {
    requestAnimationFrame(frame);
    clock.tick(now);
    const { x, y, z } = viewer.camera.position;
    if (obstacles.update(now, { x, y: -z, z: y }, points())) viewer.set_dirty();
  }
  // A plan that failed is shown where it ends, beside its nearest miss.
  const failed = page.motions.every(motion => motion.miss);
  if (failed) clock.pause();
  clock.seek(failed ? clock.duration : 0);
  camera.fit();
  document.body.classList.add("ready");
  requestAnimationFrame(frame);
  window.playback = { page, clock, camera, figures, obstacles, plots, views };
});
