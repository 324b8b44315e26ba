// SPDX-License-Identifier: MIT
//
// How the scene is looked at: a parallel projection, in which lengths can be measured, or a
// perspective; turned, shifted and zoomed by OrbitControls.

const canvas = byId("canvas");
const FIELD_OF_VIEW = 35; // degrees, of the perspective
const MARGIN = 1.12;

const vectorOf = (v) => new THREE.Vector3(v[0], v[1], v[2]);

/* The axis that stays upright: the one that the first view's upward direction is nearest to. */
const upright = (() => {
  const up = data.view.up.map(Math.abs);
  const axis = up.indexOf(Math.max(...up));
  return new THREE.Vector3(axis === 0, axis === 1, axis === 2);
})();

const orthographic = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1);
const perspective = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.1, 10);
for (const one of [orthographic, perspective]) one.up.copy(upright);
let camera = orthographic;

/* Everything that is drawn lies in this sphere. */
const whereabouts = { centre: new THREE.Vector3(), radius: 1 };
whenPlaced(() => {
  whereabouts.centre.copy(vectorOf(scene.centre));
  whereabouts.radius = scene.radius || 1;
});

const controls = new THREE.OrbitControls(camera, canvas);
controls.enableKeys = false; // main.js has the keys
controls.screenSpacePanning = true;
controls.rotateSpeed = 0.8;

/* jumps: to another view, which is drawn in full at once; else it moves. */
const sight = { jumps: false };

/* Half the height of what is seen at the point looked at. */
function halfHeight() {
  if (camera === orthographic) return whereabouts.radius / camera.zoom;
  return camera.position.distanceTo(controls.target) * Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
}

function setHalfHeight(half) {
  const toward = camera.position.clone().sub(controls.target).normalize();
  const distance = half / Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
  orthographic.zoom = whereabouts.radius / half;
  camera.position.copy(controls.target).addScaledVector(
    toward, camera === orthographic ? 6 * whereabouts.radius : distance);
  reshape();
}

/* After a change of the canvas' shape. */
function reshape() {
  const aspect = canvas.clientWidth / Math.max(canvas.clientHeight, 1);
  const radius = whereabouts.radius, reach = Math.max(10 * radius, 3 * scene.radius);
  Object.assign(orthographic, {
    left: -radius * aspect, right: radius * aspect, top: radius, bottom: -radius,
    near: -reach, far: 6 * radius + reach,
  });
  Object.assign(perspective, { aspect, near: radius / 400, far: 50 * radius + reach });
  orthographic.updateProjectionMatrix();
  perspective.updateProjectionMatrix();
}

/* Looks along -toward, with the points in sight. When the scene is seen along the upright axis,
 * `up` says what is upwards. */
function look(points, toward, up) {
  const direction = toward.clone().normalize();
  const along = direction.dot(upright);
  if (Math.abs(along) > 0.9999) direction.addScaledVector(up, -1e-4 * Math.sign(along)).normalize();
  const right = new THREE.Vector3().crossVectors(upright, direction).normalize();
  const above = new THREE.Vector3().crossVectors(direction, right);
  const box = new THREE.Box3();
  const p = new THREE.Vector3();
  for (const point of points)
    box.expandByPoint(p.set(point.dot(right), point.dot(above), point.dot(direction)));
  if (box.isEmpty()) box.expandByPoint(p.set(0, 0, 0));
  const middle = box.getCenter(new THREE.Vector3());
  const size = box.getSize(new THREE.Vector3());
  controls.target.set(0, 0, 0).addScaledVector(right, middle.x).addScaledVector(above, middle.y)
    .addScaledVector(direction, middle.z);
  camera.position.copy(controls.target).addScaledVector(direction, 6 * whereabouts.radius);
  const aspect = canvas.clientWidth / Math.max(canvas.clientHeight, 1);
  const half = Math.max(size.y, size.x / aspect, 1e-9 * whereabouts.radius) * 0.5 * MARGIN;
  setHalfHeight(half + (camera === perspective ? 0.5 * size.z * Math.tan((FIELD_OF_VIEW * Math.PI) / 360) : 0));
  sight.jumps = true;
  controls.update();
  sight.jumps = false;
}

/* The same view in the other projection. */
function changeLens() {
  const half = halfHeight();
  const toward = camera.position.clone().sub(controls.target);
  camera = camera === orthographic ? perspective : orthographic;
  controls.object = camera;
  camera.position.copy(controls.target).add(toward);
  setHalfHeight(half);
  controls.update();
}

/* Keys: angles in radians. */
function turn(aside, above) {
  const offset = camera.position.clone().sub(controls.target);
  const right = new THREE.Vector3().crossVectors(upright, offset).normalize();
  const turned = offset.clone().applyAxisAngle(right, -above).applyAxisAngle(upright, -aside);
  if (Math.abs(turned.clone().normalize().dot(upright)) < 0.9999 || above === 0)
    camera.position.copy(controls.target).add(turned);
  controls.update();
}
