// Where the camera is: fitted to the motion, following the robot, zooming to the pointer.
"use strict";

const ZOOM_STEP = 0.0011; // of the wheel

function makeCamera(viewer, pane, view) {
  const { THREE } = MeshCat, camera = viewer.camera, controls = viewer.controls;
  const inView = ([x, y, z]) => new THREE.Vector3(x, z, -y); // y points up for the camera
  const values = unpacked(view.points), points = [];
  for (let i = 0; i < values.length; i += 3) points.push(inView(values.slice(i, i + 3)));
  const middle = inView(view.middle), back = inView(view.direction).normalize();
  const listeners = [];
  let isMoved = false, followed = null;

  camera.zoom = 1;
  camera.fov = 2 * Math.atan(view.halfHeight) * 180 / Math.PI;
  controls.maxPolarAngle = 0.98 * Math.PI;
  controls.addEventListener("start", () => { isMoved = true; });

  const own = {
    middle, inView,
    radius: Math.max(...points.map(point => point.distanceTo(middle))),

    // Put the camera where it sees all the points.
    fit() {
      const right = new THREE.Vector3(0, 1, 0).cross(back).normalize(), up = back.clone().cross(right);
      const size = view.share * view.halfHeight, wide = camera.aspect;
      let distance = 0;
      for (const point of points) {
        const from = point.clone().sub(middle);
        const beside = Math.max(Math.abs(from.dot(up)), Math.abs(from.dot(right)) / wide) / size;
        distance = Math.max(distance, from.dot(back) + beside);
      }
      controls.target.copy(middle);
      camera.position.copy(middle).addScaledVector(back, distance);
      isMoved = false;
      own.moved();
    },
    refit() {
      if (!isMoved && !followed) own.fit();
    },

    // Zoom by a factor; the point under the pointer stays there.
    zoom(factor, x, y) {
      const ray = new THREE.Raycaster();
      ray.setFromCamera({ x, y }, camera);
      const facing = camera.getWorldDirection(new THREE.Vector3());
      const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(facing, controls.target);
      const at = ray.ray.intersectPlane(plane, new THREE.Vector3()) || controls.target;
      camera.position.sub(at).multiplyScalar(factor).add(at);
      controls.target.sub(at).multiplyScalar(factor).add(at);
      isMoved = true;
      own.moved();
    },

    // Go along with a point that moves; null to stay.
    follow(point) {
      if (point && followed) {
        const by = point.clone().sub(followed);
        camera.position.add(by);
        controls.target.add(by);
        own.moved();
      }
      followed = point && point.clone();
    },
    // Look at a point from where the camera is, nearer to it.
    approach(point) {
      const offset = camera.position.clone().sub(controls.target).multiplyScalar(0.55);
      controls.target.copy(point);
      camera.position.copy(point).add(offset);
      own.moved();
    },

    onMove(listener) { listeners.push(listener); },
    moved() {
      controls.update();
      viewer.set_dirty();
      for (const listener of listeners) listener();
    },
  };
  controls.addEventListener("change", () => { for (const listener of listeners) listener(); });

  // meshcat would zoom to the middle.
  pane.parentElement.addEventListener("wheel", event => {
    if (!pane.contains(event.target)) return;
    event.preventDefault();
    event.stopPropagation();
    const box = pane.getBoundingClientRect(), lines = event.deltaMode === 1 ? 16 : 1;
    const x = 2 * (event.clientX - box.left) / box.width - 1, y = 1 - 2 * (event.clientY - box.top) / box.height;
    own.zoom(Math.exp(ZOOM_STEP * lines * event.deltaY), x, y);
  }, { capture: true, passive: false });
  pane.addEventListener("dblclick", own.fit);
  return own;
}
