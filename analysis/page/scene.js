// SPDX-License-Identifier: MIT
//
// Objects as meshes: glass is translucent and denser at its rim, metal shines, the rest is opaque.
// Detectors and sources as outlines.

const CREASE = Math.cos((35 * Math.PI) / 180);
const MOST_EDGES = 300000; // triangles of a geometry whose edges are still looked for
const ENCLOSING = 0.7; // an object that spans this part of the scene twice encloses it

const VERTEX = `
  varying vec3 vNormal, vView;
  void main() {
    vec4 view = modelViewMatrix * vec4(position, 1.0);
    vView = view.xyz;
    vNormal = normalMatrix * normal;
    gl_Position = projectionMatrix * view;
  }`;

const FRAGMENT = `
  uniform vec3 tint, middle;
  uniform float look, encloses, cut, parallel;
  varying vec3 vNormal, vView;
  void main() {
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
const shading = {
  middle: { value: whereabouts.centre }, cut: { value: 0 }, parallel: { value: 1 },
};

const GLASS = 0, METAL = 1, OPAQUE = 2;
const lookOf = { glass: GLASS, metal: METAL, opaque: OPAQUE };

/* Of 3 corners the unit normal, 0 for a triangle without area. */
function faceNormals(place, corner) {
  const n = new Float32Array(corner.length);
  const a = new THREE.Vector3(), b = new THREE.Vector3(), c = new THREE.Vector3();
  for (let i = 0; i < corner.length; i += 3) {
    a.fromArray(place, 3 * corner[i]);
    b.fromArray(place, 3 * corner[i + 1]).sub(a);
    c.fromArray(place, 3 * corner[i + 2]).sub(a);
    b.cross(c).normalize().toArray(n, i);
  }
  return n;
}

/* Triangles around every vertex: those of vertex v are of[first[v]] to of[first[v + 1] - 1]. */
function trianglesAround(corner, nVertex) {
  const first = new Uint32Array(nVertex + 2);
  for (const v of corner) first[v + 2]++;
  for (let v = 2; v < nVertex + 2; v++) first[v] += first[v - 1];
  const of = new Uint32Array(corner.length);
  for (let i = 0; i < corner.length; i++) of[first[corner[i] + 1]++] = Math.floor(i / 3);
  return { first, of };
}

/* Triangles with corners of their own; normals are smooth but for creases. */
function creased(place, corner) {
  const face = faceNormals(place, corner);
  const around = trianglesAround(corner, place.length / 3);
  const position = new Float32Array(3 * corner.length);
  const normal = new Float32Array(3 * corner.length);
  for (let i = 0; i < corner.length; i++) {
    const own = i - (i % 3), v = corner[i];
    let x = 0, y = 0, z = 0;
    for (let k = around.first[v]; k < around.first[v + 1]; k++) {
      const t = 3 * around.of[k];
      if (face[t] * face[own] + face[t + 1] * face[own + 1] + face[t + 2] * face[own + 2] < CREASE) continue;
      x += face[t]; y += face[t + 1]; z += face[t + 2];
    }
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    normal[3 * i] = x / length; normal[3 * i + 1] = y / length; normal[3 * i + 2] = z / length;
    for (let k = 0; k < 3; k++) position[3 * i + k] = place[3 * v + k];
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 3));
  return geometry;
}

/* Rims and creases, as pairs of points. */
function edges(place, corner) {
  const geometry = new THREE.BufferGeometry();
  const line = [];
  const face = faceNormals(place, corner), nVertex = place.length / 3, seen = new Map();
  const draw = (key) => {
    for (const v of [Math.floor(key / nVertex), key % nVertex]) line.push(place[3 * v], place[3 * v + 1], place[3 * v + 2]);
  };
  for (let i = 0; i < corner.length && corner.length < 3 * MOST_EDGES; i++) {
    const own = i - (i % 3), a = corner[i], b = corner[own + ((i + 1) % 3)];
    const key = Math.min(a, b) * nVertex + Math.max(a, b), other = seen.get(key);
    if (other === undefined) {
      seen.set(key, own);
      continue;
    }
    seen.delete(key);
    if (face[own] * face[other] + face[own + 1] * face[other + 1] + face[own + 2] * face[other + 2] < CREASE)
      draw(key);
  }
  for (const key of seen.keys()) draw(key);
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(line), 3));
  return geometry;
}

/* A profile of radii and heights turned about the axis; a radius of 0 is a pole. */
function revolved(profile, facets) {
  const rings = profile.length / 2, place = [], corner = [];
  const vertex = (i, k) => i * facets + (profile[2 * i] > 0 ? k % facets : 0);
  for (let i = 0; i < rings; i++)
    for (let k = 0; k < facets; k++) {
      const angle = (2 * Math.PI * k) / facets;
      place.push(profile[2 * i] * Math.cos(angle), profile[2 * i] * Math.sin(angle), profile[2 * i + 1]);
    }
  for (let i = 0; i + 1 < rings; i++)
    for (let k = 0; k < facets; k++) {
      const [a, b, c, d] = [vertex(i, k), vertex(i + 1, k), vertex(i + 1, k + 1), vertex(i, k + 1)];
      for (const t of [[a, b, c], [a, c, d]]) if (t[0] !== t[1] && t[1] !== t[2] && t[0] !== t[2]) corner.push(...t);
    }
  return { place: new Float32Array(place), corner: new Uint32Array(corner) };
}

function triangles(packed) {
  if (packed.profile) return revolved(unpack(packed.profile), packed.facets);
  const part = unpack(packed.place);
  const place = Float32Array.from(part, (v, i) => packed.low[i % 3] + (packed.size[i % 3] * v) / 65535);
  return { place, corner: unpack(packed.corner) };
}

/* By what they are made of (keys: of those of the scene): those of the data before serve again. */
let geometries = new Map(), geometriesBefore = new Map(), geometryKeys = [];
whenScene(() => {
  [geometries, geometriesBefore] = [new Map(), geometries];
  geometryKeys = data.geometries.map((one) => JSON.stringify(one));
});

/* Geometry g, made when its first object needs it. */
function geometryOf(g) {
  const key = geometryKeys[g];
  if (geometries.has(key)) return geometries.get(key);
  const { place, corner } = geometriesBefore.has(key) ? {} : triangles(data.geometries[g]);
  const made = geometriesBefore.get(key) || { solid: creased(place, corner), line: edges(place, corner) };
  geometries.set(key, made);
  return made;
}

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

const glassLine = outlineMaterial(() => ({ ink: scheme.dark ? "#7fb2dd" : "#3a6f9f", opacity: 0.55 }));
const solidLine = outlineMaterial(() => ({ ink: scheme.dark ? "#aab4be" : "#454545", opacity: 0.35 }));
const detectorLine = outlineMaterial(() => ({ ink: scheme.dark ? "#5fd0c4" : "#0f766e", opacity: 1 }));
const sourceLine = outlineMaterial(() => ({ ink: scheme.dark ? "#fb9a62" : "#c2410c", opacity: 1 }));

/* sRGB of what it reflects, never darker than can be told from the ground. */
function tintOf(object) {
  if (object.look === "glass") return scheme.dark ? [0.5, 0.72, 0.92] : [0.55, 0.75, 0.93];
  if (object.look === "metal") return object.albedo.map((v, k) => [0.72, 0.7, 0.76][k] * (0.35 + 0.65 * Math.pow(v, 1 / 2.2)));
  const least = scheme.dark ? 0.16 : 0.3;
  return object.albedo.map((v) => least + (0.93 - least) * Math.pow(v, 1 / 2.2));
}

function solidMaterial(object) {
  const glass = object.look === "glass";
  const uniforms = { ...shading, tint: { value: new THREE.Vector3() }, look: { value: lookOf[object.look] }, encloses: { value: 0 } };
  scheme.bodies.push(() => uniforms.tint.value.fromArray(tintOf(object)));
  return new THREE.ShaderMaterial({
    uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT, side: THREE.DoubleSide,
    transparent: glass, depthWrite: !glass,
  });
}

/* Corners of boxes about what the first view must show. */
const inSight = [];

/* What stands in the world for the present scene. */
const drawn = [];
function add(thing) {
  drawn.push(thing);
  world.add(thing);
  return thing;
}

function boxCorners(box) {
  const corner = (k) => new THREE.Vector3(k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z);
  return Array.from({ length: 8 }, (_, k) => corner(k));
}

/* [{object, group, box, corners}] in the order of the scene's objects; names of those not shown. */
const bodies = [], hidden = new Set();

function bodyOf(object, index) {
  const { solid, line } = geometryOf(object.geometry);
  const group = new THREE.Group();
  const mesh = new THREE.Mesh(solid, solidMaterial(object));
  mesh.renderOrder = object.look === "glass" ? 3 : 0;
  const outline = new THREE.LineSegments(line, object.look === "glass" ? glassLine : solidLine);
  outline.renderOrder = 1;
  group.add(mesh, outline);
  group.matrixAutoUpdate = false;
  group.matrix.copy(matrixOf(object.matrix));
  group.userData.object = index;
  group.visible = !hidden.has(object.name);
  add(group);
  if (!solid.boundingBox) solid.computeBoundingBox();
  const corners = boxCorners(solid.boundingBox).map((p) => p.applyMatrix4(group.matrix));
  inSight.push(...corners);
  return { object, group, mesh, corners, box: new THREE.Box3().setFromPoints(corners) };
}

function openEnclosing() {
  const whole = new THREE.Box3().setFromPoints(inSight).getSize(new THREE.Vector3());
  for (const body of bodies) {
    const own = body.box.getSize(new THREE.Vector3());
    const spans = ["x", "y", "z"].filter((k) => whole[k] > 0 && own[k] >= ENCLOSING * whole[k]).length;
    body.mesh.material.uniforms.encloses.value = spans >= 2 && body.object.look !== "glass" ? 1 : 0;
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
  const group = add(new THREE.Group());
  group.matrixAutoUpdate = false;
  group.add(...lines);
  outlines.push({ name, group, box: new THREE.Box3().setFromObject(group), label: addLabel(name, kind, at) });
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
  drawn.length = inSight.length = outlines.length = 0;
  bodies.splice(0, bodies.length, ...scene.objects.map(bodyOf));
  openEnclosing();
  for (const detector of detectors) if (detector.type === "plane") outlineDetector(detector);
  outlineSources();
});
frames.before.push(() => (shading.parallel.value = camera === orthographic ? 1 : 0));
