// SPDX-License-Identifier: MIT
//
// Objects as meshes: glass is translucent and denser at its rim, metal shines, the rest is opaque.
// Detectors and sources as outlines.

const ENCLOSING = 0.7; // an object that spans this part of the scene twice encloses it

/* Bodies are copies in packs; of each body there are four texels: rows of its matrix, and its paint: tint, look, and 4 more where
 * it encloses the scene. A pack tells the first of its places and their end. */
const ACROSS = 256; // places in a line of texels
const PLACED = `
  uniform highp sampler2D places;
  uniform float lines;
  attribute vec2 pack;
  attribute float copy;
  vec4 texel(float k) {
    float at = pack.x + copy, line = floor(at / ${ACROSS}.0);
    return texture2D(places, vec2((4.0 * (at - ${ACROSS}.0 * line) + k + 0.5) / ${4 * ACROSS}.0, (line + 0.5) / lines));
  }
  vec4 onScreen(vec4 view) {
    return pack.x + copy < pack.y ? projectionMatrix * view : vec4(2.0, 2.0, 2.0, 1.0);
  }
  vec4 placed(vec4 x, vec4 y, vec4 z) {
    vec4 at = vec4(position, 1.0);
    return modelViewMatrix * vec4(dot(x, at), dot(y, at), dot(z, at), 1.0);
  }`;

const VERTEX = `${PLACED}
  varying vec3 vNormal, vView;
  varying vec4 vPaint;
  void main() {
    vec4 x = texel(0.0), y = texel(1.0), z = texel(2.0), view = placed(x, y, z);
    vView = view.xyz;
    vNormal = normalMatrix * vec3(dot(cross(y.xyz, z.xyz), normal), dot(cross(z.xyz, x.xyz), normal), dot(cross(x.xyz, y.xyz), normal));
    vPaint = texel(3.0);
    gl_Position = onScreen(view);
  }`;

const FRAGMENT = `
  uniform vec3 middle;
  uniform float cut, parallel;
  varying vec3 vNormal, vView;
  varying vec4 vPaint;
  void main() {
    vec3 tint = vPaint.xyz;
    float encloses = step(3.5, vPaint.w), look = vPaint.w - 4.0 * encloses;
    vec3 n = normalize(vNormal);
    vec3 eye = parallel > 0.5 ? vec3(0.0, 0.0, 1.0) : normalize(-vView);
    vec3 out_of = vView - (viewMatrix * vec4(middle, 1.0)).xyz;
    float facing = dot(n, eye);
    if (encloses > 0.5 && dot(out_of, n) * facing > 0.0) discard; // stands before the scene
    if (cut > 0.5 && look > 0.5 && dot(out_of, eye) > 0.0) discard;
    if (facing < 0.0) n = -n;
    float rim = 1.0 - abs(facing);
    float lit = max(dot(n, normalize(vec3(-0.35, 0.55, 0.76))), 0.0);
    if (look < 0.5) {
      gl_FragColor = vec4(tint * (0.75 + 0.25 * lit), mix(0.13, 0.55, rim * rim * rim));
    } else if (look < 1.5) {
      float shine = pow(max(dot(reflect(-eye, n), normalize(vec3(-0.35, 0.55, 0.76))), 0.0), 12.0);
      gl_FragColor = vec4(tint * (0.45 + 0.4 * lit) + vec3(0.35 * shine), 1.0);
    } else {
      gl_FragColor = vec4(tint * (0.5 + 0.5 * lit), 1.0);
    }
  }`;

/* Shared by all materials: one value serves every object. */
const placing = { places: { value: null }, lines: { value: 1 } };
const shading = {
  ...placing,
  middle: { value: whereabouts.centre }, cut: { value: 0 }, parallel: { value: 1 },
};

const GLASS = 0, METAL = 1, OPAQUE = 2;
const lookOf = { glass: GLASS, metal: METAL, opaque: OPAQUE };

const matrixOf = (m) => new THREE.Matrix4().set(...m, 0, 0, 0, 1);

function outlineMaterial(colourOf) {
  const material = new THREE.LineBasicMaterial({ transparent: true });
  const tell = () => {
    const { ink, opacity } = colourOf();
    material.color.set(ink);
    material.opacity = opacity;
  };
  scheme.told.push(tell);
  return material;
}

const detectorLine = outlineMaterial(() => ({ ink: scheme.dark ? "#5fd0c4" : "#0f766e", opacity: 1 }));
const sourceLine = outlineMaterial(() => ({ ink: scheme.dark ? "#fb9a62" : "#c2410c", opacity: 1 }));

/* sRGB of what it reflects, never darker than can be told from the ground. */
function tintOf(object) {
  if (object.look === "glass") return scheme.dark ? [0.5, 0.72, 0.92] : [0.55, 0.75, 0.93];
  if (object.look === "metal") return object.albedo.map((v, k) => [0.72, 0.7, 0.76][k] * (0.35 + 0.65 * Math.pow(v, 1 / 2.2)));
  const least = scheme.dark ? 0.16 : 0.3;
  return object.albedo.map((v) => least + (0.93 - least) * Math.pow(v, 1 / 2.2));
}

function edgeMaterial(colourOf) {
  const uniforms = { ...placing, ink: { value: new THREE.Color() }, opacity: { value: 1 } };
  scheme.told.push(() => {
    const { ink, opacity } = colourOf();
    uniforms.ink.value.set(ink);
    uniforms.opacity.value = opacity;
  });
  return new THREE.ShaderMaterial({ uniforms, transparent: true,
    vertexShader: `${PLACED} void main() { gl_Position = onScreen(placed(texel(0.0), texel(1.0), texel(2.0))); }`,
    fragmentShader: "uniform vec3 ink; uniform float opacity; void main() { gl_FragColor = vec4(ink, opacity); }" });
}

const bodyMaterial = (more) => new THREE.ShaderMaterial({ uniforms: shading, vertexShader: VERTEX, fragmentShader: FRAGMENT, side: THREE.DoubleSide, ...more });

/* By whether it is of glass. */
const solidMaterials = [bodyMaterial({}), bodyMaterial({ transparent: true, depthWrite: false })];
const lineMaterials = [edgeMaterial(() => ({ ink: scheme.dark ? "#aab4be" : "#454545", opacity: 0.35 })),
  edgeMaterial(() => ({ ink: scheme.dark ? "#7fb2dd" : "#3a6f9f", opacity: 0.55 }))];

/* Corners of boxes about what the first view must show. */
const inSight = [];

function boxCorners(box, corners) {
  corners.forEach((p, k) => p.set(k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z));
}

/* [{object, shape, matrix, corners, box, sphere, encloses, visible, row}] in the order of the scene's objects; names of those not shown.
 * batches: of a shape and a material, [{shape, glass, bodies, middle, levels, stale}]: each is drawn at once. */
const bodies = [], hidden = new Set(), batches = [];

function placeBody(body, matrix) {
  body.matrix.copy(matrix);
  boxCorners(body.shape.box, body.corners);
  for (const p of body.corners) p.applyMatrix4(matrix);
  body.box.setFromPoints(body.corners);
  body.sphere.copy(body.shape.sphere).applyMatrix4(matrix);
  body.batch.stale = true;
}

function bodyOf(object, batch) {
  const body = { object, shape: batch.shape, batch, matrix: new THREE.Matrix4(), corners: Array.from({ length: 8 }, () => new THREE.Vector3()),
    box: new THREE.Box3(), sphere: new THREE.Sphere(), encloses: false, visible: !hidden.has(object.name), row: new Float32Array(16) };
  batch.bodies.push(body);
  return body;
}

function makeBodies() {
  const own = new Map();
  const batchOf = ({ geometry, look }) => {
    const glass = look === "glass" ? 1 : 0, key = 2 * geometry + glass;
    if (!own.has(key)) own.set(key, { shape: shapeOf(geometry), glass, bodies: [], middle: new THREE.Vector3(), levels: [], stale: true });
    return own.get(key);
  };
  bodies.splice(0, bodies.length, ...scene.objects.map((object) => bodyOf(object, batchOf(object))));
  batches.splice(0, batches.length, ...own.values());
  if (placing.places.value) placing.places.value.dispose();
  placing.lines.value = Math.ceil((bodies.length + 1) / ACROSS);
  placing.places.value = new THREE.DataTexture(new Float32Array(16 * ACROSS * placing.lines.value), 4 * ACROSS, placing.lines.value, THREE.RGBAFormat, THREE.FloatType);
}

const drawn = []; // of all batches
const PACK = 2000; // triangles: what is small costs no less when it is drawn alone

/* So many copies of a geometry. */
function copiesOf({ attributes, index }, copies) {
  const geometry = new THREE.InstancedBufferGeometry(), n = attributes.position.count;
  const times = (array, call) => Float32Array.from({ length: copies * array.length }, (_, i) => call(array, i));
  for (const name of Object.keys(attributes))
    geometry.setAttribute(name, new THREE.BufferAttribute(times(attributes[name].array, (array, i) => array[i % array.length]), 3));
  geometry.setAttribute("copy", new THREE.BufferAttribute(times({ length: n }, (_, i) => Math.floor(i / n)), 1));
  geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from({ length: copies * index.count }, (_, i) => index.array[i % index.count] + n * Math.floor(i / index.count)), 1));
  return geometry;
}

/* What of a batch is drawn in that fineness: its members are found anew for each frame. */
function drawnLevel(batch, level) {
  const triangles = Math.max(level.solid.index.count / 3, 1), n = batch.bodies.length;
  const most = Math.ceil(n / Math.ceil(PACK / triangles)), copies = Math.ceil(n / most);
  const packs = new THREE.InstancedBufferAttribute(new Float32Array(2 * most), 2).setUsage(THREE.DynamicDrawUsage);
  const part = (of, Kind, material, order) => {
    const geometry = copiesOf(of, copies), thing = new Kind(geometry.setAttribute("pack", packs), material);
    drawn.push(thing);
    world.add(thing);
    thing.frustumCulled = false;
    thing.renderOrder = order;
    return thing;
  };
  return { packs, copies, triangles, members: [], parts: [part(level.solid, THREE.Mesh, solidMaterials[batch.glass], batch.glass ? 3 : 0),
    part(level.line, THREE.LineSegments, lineMaterials[batch.glass], 1)] };
}

/* About the middle of all: sorted by it, and in short numbers. */
function fillRows({ bodies: own, middle }) {
  middle.set(0, 0, 0);
  for (const { matrix } of own) middle.addScaledVector(new THREE.Vector3().setFromMatrixPosition(matrix), 1 / own.length);
  for (const { matrix: { elements: e }, object, encloses, row } of own) {
    for (let k = 0; k < 3; k++) row.set([e[k], e[4 + k], e[8 + k], e[12 + k] - middle.getComponent(k)], 4 * k);
    row.set([...tintOf(object), lookOf[object.look] + (encloses ? 4 : 0)], 12);
  }
}

const NEGLIGIBLE = drawnBySoftware ? 1 : 0.3; // pixels that a surface may be off

/* As many as there are in sight when nothing moves. */
let atRest = 0;
const trianglesAtRest = () => atRest;

/* What is in sight, in the finenesses that can be told apart there. */
function fillBatches() {
  let placed = 0, triangles = 0;
  camera.updateMatrixWorld();
  const frustum = new THREE.Frustum().setFromMatrix(new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, new THREE.Matrix4().getInverse(camera.matrixWorld)));
  const grain = NEGLIGIBLE * Math.pow(2, Math.max(pace.level - 1, 0)), isFar = camera === perspective;
  const perPixel = 2 / Math.max(canvas.height, 1) * (isFar ? Math.tan((FIELD_OF_VIEW * Math.PI) / 360) : halfHeight());
  for (const batch of batches) {
    if (batch.stale) fillRows(batch);
    batch.stale = false;
    for (const one of batch.levels) if (one) one.members.length = 0;
    for (const body of batch.bodies) {
      const { visible, sphere } = body;
      if (!visible || !frustum.intersectsSphere(sphere)) continue;
      const pixel = isFar ? perPixel * Math.max(sphere.center.distanceTo(camera.position) - sphere.radius, camera.near) : perPixel;
      const k = batch.shape.levelFor((grain * pixel * batch.shape.sphere.radius) / (sphere.radius || 1));
      (batch.levels[k] || (batch.levels[k] = drawnLevel(batch, batch.shape.level(k)))).members.push(body);
    }
    for (const one of batch.levels) {
      if (!one) continue;
      placed = showLevel(one, batch.middle, placed);
      triangles += one.triangles * one.members.length;
    }
  }
  placing.places.value.needsUpdate = true;
  if (pace.level > 0) return;
  const before = lastLevel();
  atRest = triangles;
  if (drawnBySoftware && lastLevel() !== before) pace.known = lastLevel();
}

/* From that place on; the next one. */
function showLevel({ packs, copies, members, parts }, middle, first) {
  const end = first + members.length, count = Math.ceil(members.length / copies), { data: texels } = placing.places.value.image;
  members.forEach(({ row }, k) => texels.set(row, 16 * (first + k)));
  for (let k = 0; k < count; k++) packs.setXY(k, first + k * copies, end);
  packs.needsUpdate = true;
  for (const part of parts) {
    part.position.copy(middle);
    part.visible = count > 0;
    part.geometry.maxInstancedCount = count;
  }
  return end;
}
let painted = null;
scheme.told.push(() => {
  if (painted !== scheme.dark) for (const batch of batches) batch.stale = true;
  painted = scheme.dark;
});

function openEnclosing() {
  const whole = new THREE.Box3().setFromPoints(inSight).getSize(new THREE.Vector3());
  for (const body of bodies) {
    const own = body.box.getSize(new THREE.Vector3());
    const spans = ["x", "y", "z"].filter((k) => whole[k] > 0 && own[k] >= ENCLOSING * whole[k]).length;
    body.encloses = spans >= 2 && body.object.look !== "glass";
  }
}

function polyline(points, material) {
  const geometry = new THREE.BufferGeometry().setFromPoints(points);
  const line = new THREE.Line(geometry, material);
  line.renderOrder = 1;
  return line;
}

/* [{name, group, box, label}] of the sources and detectors that have a place */
const outlines = [];

function addOutline(name, kind, at, ...lines) {
  const group = new THREE.Group();
  world.add(group);
  group.matrixAutoUpdate = false;
  group.add(...lines);
  outlines.push({ name, group, matrix: group.matrix, box: new THREE.Box3().setFromObject(group), label: addLabel(name, kind, at) });
}

function outlineDetector(detector) {
  const at = vectorOf(detector.origin), corner = (u, v) => at.clone()
    .addScaledVector(vectorOf(detector.x), 0.5 * u * detector.size[0])
    .addScaledVector(vectorOf(detector.y), 0.5 * v * detector.size[1]);
  const points = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1), corner(-1, -1)];
  inSight.push(...points);
  addOutline(detector.name, "detector", corner(1, 1), polyline(points, detectorLine));
}

/* A source further from the objects than 1.5 times their size is left out of the first view. */
function outlineSources() {
  const box = new THREE.Box3().setFromPoints(inSight);
  const size = box.isEmpty() ? 1 : box.getSize(new THREE.Vector3()).length();
  for (const source of scene.sources) {
    const matrix = matrixOf(source.matrix), at = new THREE.Vector3().setFromMatrixPosition(matrix);
    const round = (r) => Array.from({ length: 65 }, (_, k) =>
      new THREE.Vector3(r * Math.cos((k * Math.PI) / 32), r * Math.sin((k * Math.PI) / 32), 0));
    const [w, h] = source.size.map((v) => 0.5 * v);
    const outline = { disc: () => round(source.size[0]), rectangle: () => [[-w, -h], [w, -h], [w, h], [-w, h], [-w, -h]].map(([x, y]) => new THREE.Vector3(x, y, 0)) }[source.shape];
    const points = (outline ? outline() : [new THREE.Vector3(0, 0, 0)]).map((p) => p.applyMatrix4(matrix));
    const axis = [at, new THREE.Vector3(0, 0, 1).transformDirection(matrix).multiplyScalar(0.04 * size).add(at)];
    addOutline(source.name, "source", at.clone(), ...(outline ? [points, axis] : [axis]).map((line) => polyline(line, sourceLine)));
    if (box.isEmpty() || box.distanceToPoint(at) < 1.5 * size) inSight.push(...points);
  }
  const all = new THREE.Box3().setFromPoints(inSight);
  if (!all.isEmpty()) {
    const sphere = all.getBoundingSphere(new THREE.Sphere());
    whereabouts.centre.copy(sphere.center);
    whereabouts.radius = sphere.radius || whereabouts.radius;
  }
}

whenScene(() => {
  world.remove(...drawn);
  for (const { geometry } of drawn) geometry.dispose();
  drawn.length = 0;
  makeBodies();
});
whenPlaced(() => {
  world.remove(...outlines.map(({ group }) => group));
  inSight.length = outlines.length = 0;
  for (const body of bodies) {
    placeBody(body, matrixOf(body.object.matrix));
    body.encloses = false;
    inSight.push(...body.corners);
  }
  openEnclosing();
  for (const detector of detectors) if (detector.type === "plane") outlineDetector(detector);
  outlineSources();
});
frames.before.push(() => (shading.parallel.value = camera === orthographic ? 1 : 0), fillBatches);
