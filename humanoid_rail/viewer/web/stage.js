// Sky, floor, light and shadows.
"use strict";

const HORIZON = 0xe8edf2, ZENITH = 0xf8fafc, FLOOR = 0xdfe5eb, LINES = 0xb4bfca;
const MOST_SHADOWS = 3000; // of more bodies than this, obstacles have no shadows
const SHADOWS = 2048; // width of the picture that shadows are made of, pixels

// Return a copy of a geometry coloured by height, from the horizon to the zenith.
function skyGeometry() {
  const geometry = new MeshCat.THREE.SphereGeometry(1, 24, 24);
  const low = new MeshCat.THREE.Color(HORIZON), high = new MeshCat.THREE.Color(ZENITH);
  const at = geometry.attributes.position, colours = [];
  for (let i = 0; i < at.count; i++) {
    const colour = low.clone().lerp(high, Math.min(Math.max(at.getY(i) * 2.5, 0), 1));
    colours.push(colour.r, colour.g, colour.b);
  }
  geometry.setAttribute("color", new MeshCat.THREE.Float32BufferAttribute(colours, 3));
  return geometry;
}

// Set the scene up around what is to be seen: its middle and radius, in meshcat's frame, and the height of the floor.
function makeStage(viewer, middle, radius, floor, scale) {
  const { THREE } = MeshCat, scene = viewer.scene;
  for (const name of ["Grid", "Axes", "Lights"]) viewer.scene_tree.find([name]).object.visible = false;
  scene.background = null;
  scene.fog = new THREE.Fog(HORIZON, 1, 10);

  const stage = new THREE.Group(); // its y axis points up, unlike meshcat's
  stage.rotation.x = Math.PI / 2;
  stage.name = "stage";
  scene.add(stage);

  const sky = new THREE.Mesh(
    skyGeometry(),
    new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.BackSide, fog: false, depthWrite: false }),
  );
  sky.renderOrder = -100;
  stage.add(sky);

  const flat = new THREE.CircleGeometry(1, 64);
  flat.rotateX(-Math.PI / 2);
  const ground = new THREE.Mesh(flat, new THREE.MeshBasicMaterial({ color: FLOOR, depthWrite: false }));
  const shade = new THREE.Mesh(flat, new THREE.ShadowMaterial({ opacity: 0.16, depthWrite: false }));
  const lines = new THREE.GridHelper(80 * scale, 80, LINES, LINES);
  lines.material.transparent = true;
  lines.material.opacity = 0.4;
  lines.material.depthWrite = false;
  ground.renderOrder = -90;
  lines.renderOrder = -80;
  shade.renderOrder = -70;
  shade.receiveShadow = true;
  for (const each of [ground, lines, shade]) {
    each.position.set(middle.x, floor, middle.z);
    stage.add(each);
  }
  // Lines at whole metres, or parts of them for small robots.
  lines.position.x = Math.round(middle.x / scale) * scale;
  lines.position.z = Math.round(middle.z / scale) * scale;
  shade.scale.setScalar(4 * radius);

  stage.add(new THREE.HemisphereLight(0xffffff, 0xa9b3bf, 0.6));
  const sun = new THREE.DirectionalLight(0xfff6e8, 0.42);
  sun.position.copy(middle).add(new THREE.Vector3(0.45, 1.3, 0.7).multiplyScalar(2.5 * radius));
  sun.target.position.copy(middle);
  sun.castShadow = true;
  sun.shadow.mapSize.set(SHADOWS, SHADOWS);
  const seen = sun.shadow.camera, half = 1.35 * radius;
  Object.assign(seen, { left: -half, right: half, top: half, bottom: -half, near: 0.5 * radius, far: 6 * radius });
  sun.shadow.normalBias = 0.01 * radius;
  sun.shadow.bias = -0.0005;
  sun.shadow.radius = 3;
  stage.add(sun, sun.target);

  const fill = new THREE.DirectionalLight(0xe6eeff, 0.1);
  stage.add(fill);

  return {
    // Let what is drawn cast shadows, unless it can be looked through.
    castShadows(count) {
      const cast = object => {
        for (let up = object; up; up = up.parent) if (["closest", "traces", "targets"].includes(up.name)) return false;
        return !object.material.transparent && (!object.isInstancedMesh || count <= MOST_SHADOWS);
      };
      viewer.scene_tree.find(["meshcat", "world"]).object.traverse(object => {
        object.castShadow = object.receiveShadow = false;
        if (!object.isMesh) return;
        object.castShadow = cast(object);
        object.receiveShadow = !object.material.transparent && count <= MOST_SHADOWS;
      });
    },
    // Follow the camera: the horizon is as far away as suits its distance from what it looks at.
    update(camera, target) {
      const distance = Math.max(camera.position.distanceTo(target), 0.3 * radius);
      camera.near = distance / 200;
      camera.far = 40 * distance + 10 * radius;
      scene.fog.near = distance + 1.2 * radius;
      scene.fog.far = 2 * distance + 6 * radius;
      ground.scale.setScalar(0.9 * camera.far);
      sky.position.copy(camera.position);
      sky.scale.setScalar(0.95 * camera.far);
      fill.position.copy(camera.position).sub(target);
    },
  };
}
