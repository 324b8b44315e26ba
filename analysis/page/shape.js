// SPDX-License-Identifier: MIT
//
// Bodies as triangles and edges, in several finenesses: what is small on the screen is drawn of fewer.

const CREASE = Math.cos((35 * Math.PI) / 180);
const MOST_EDGES = 300000; // triangles of a geometry whose edges are still looked for

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

/* Normals of corners: smooth but for creases. */
function creased(place, corner, face) {
  const around = trianglesAround(corner, place.length / 3);
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
  }
  return normal;
}

/* Rims and creases as pairs of points; which points lie on a rim. */
function edges(place, corner, face) {
  const pair = [], nVertex = place.length / 3, rim = new Uint8Array(nVertex), seen = new Map();
  for (let i = 0; i < corner.length && corner.length < 3 * MOST_EDGES; i++) {
    const own = i - (i % 3), a = corner[i], b = corner[own + ((i + 1) % 3)];
    const key = Math.min(a, b) * nVertex + Math.max(a, b), other = seen.get(key);
    if (other === undefined) {
      seen.set(key, own);
      continue;
    }
    seen.delete(key);
    if (face[own] * face[other] + face[own + 1] * face[other + 1] + face[own + 2] * face[other + 2] < CREASE)
      pair.push(a, b);
  }
  for (const key of seen.keys()) {
    const ends = [Math.floor(key / nVertex), key % nVertex];
    for (const v of ends) rim[v] = 1;
    pair.push(...ends);
  }
  return { pair, rim };
}

/* Corners at one point whose normals differ little (cosine at least `near`) are one vertex. */
function joined(at, normal, nPoint, near) {
  const corner = new Uint32Array(at.length), newest = new Int32Array(nPoint).fill(-1);
  const before = new Int32Array(at.length), of = new Uint32Array(at.length), sum = new Float32Array(normal.length), first = new Uint32Array(at.length);
  let n = 0;
  for (let i = 0; i < at.length; i++) {
    let v = newest[at[i]];
    for (; v >= 0; v = before[v]) {
      const k = 3 * first[v];
      if (normal[k] * normal[3 * i] + normal[k + 1] * normal[3 * i + 1] + normal[k + 2] * normal[3 * i + 2] >= near) break;
    }
    if (v < 0) {
      v = n++;
      before[v] = newest[at[i]];
      newest[at[i]] = v;
      of[v] = at[i];
      first[v] = i;
    }
    for (let k = 0; k < 3; k++) sum[3 * v + k] += normal[3 * i + k];
    corner[i] = v;
  }
  for (let v = 0; v < n; v++) {
    const length = Math.hypot(sum[3 * v], sum[3 * v + 1], sum[3 * v + 2]) || 1;
    for (let k = 0; k < 3; k++) sum[3 * v + k] /= length;
  }
  return { corner, of: of.slice(0, n), normal: sum.slice(0, 3 * n) };
}

/* {place: of points, rim, pair: edges, corner, of: the point of a vertex, normal: of vertices, error: how far off at most} */
function finest(place, all) {
  const normals = faceNormals(place, all), hasArea = (_, i) => normals[i - (i % 3)] || normals[i - (i % 3) + 1] || normals[i - (i % 3) + 2];
  const corner = all.filter(hasArea), face = normals.filter(hasArea);
  return { place, ...edges(place, all, normals), ...joined(corner, creased(place, corner, face), place.length / 3, 1 - 1e-6), error: 0 };
}

/* The cell of every point of a cubic grid with so many cells along the longest side, numbered as they come. */
function cellsOf(place, cells) {
  const box = new THREE.Box3().setFromArray(place), size = box.getSize(new THREE.Vector3());
  const step = Math.max(size.x, size.y, size.z) / cells || 1, number = new Map(), of = new Uint32Array(place.length / 3);
  const along = (v, low) => Math.min(Math.floor((v - low) / step), cells - 1);
  for (let i = 0; i < of.length; i++) {
    const key = along(place[3 * i], box.min.x) + cells * (along(place[3 * i + 1], box.min.y) + cells * along(place[3 * i + 2], box.min.z));
    if (!number.has(key)) number.set(key, number.size);
    of[i] = number.get(key);
  }
  return { of, n: number.size };
}

/* The points of each cell become one in their middle (vertex clustering: Rossignac and Borrel 1993). What counts as
 * error is how far a surface moves out of itself, and a rim at all. */
function coarser(fine, cells) {
  const cell = cellsOf(fine.place, cells), place = new Float32Array(3 * cell.n), rim = new Uint8Array(cell.n), count = new Uint32Array(cell.n);
  cell.of.forEach((c, i) => {
    count[c]++;
    rim[c] |= fine.rim[i];
    for (let k = 0; k < 3; k++) place[3 * c + k] += (fine.place[3 * i + k] - place[3 * c + k]) / count[c];
  });
  let most = 0;
  for (let v = 0; v < fine.of.length; v++) {
    const i = fine.of[v], c = cell.of[i], d = [0, 1, 2].map((k) => fine.place[3 * i + k] - place[3 * c + k]);
    most = Math.max(most, fine.rim[i] ? Math.hypot(...d) : Math.abs(d[0] * fine.normal[3 * v] + d[1] * fine.normal[3 * v + 1] + d[2] * fine.normal[3 * v + 2]));
  }
  const at = [], normal = [], pair = [], seen = new Set();
  for (let t = 0; t < fine.corner.length; t += 3) {
    const own = fine.corner.subarray(t, t + 3), [a, b, c] = Array.from(own, (v) => cell.of[fine.of[v]]);
    if (a === b || b === c || a === c) continue;
    at.push(a, b, c);
    for (const v of own) normal.push(fine.normal[3 * v], fine.normal[3 * v + 1], fine.normal[3 * v + 2]);
  }
  for (let i = 0; i < fine.pair.length; i += 2) {
    const a = cell.of[fine.pair[i]], b = cell.of[fine.pair[i + 1]], key = Math.min(a, b) * cell.n + Math.max(a, b);
    if (a === b || seen.has(key)) continue;
    seen.add(key);
    pair.push(a, b);
  }
  return { place, rim, pair, ...joined(at, normal, cell.n, CREASE), error: fine.error + most };
}

/* Each with less than 0.6 of the triangles of the one before. */
function coarserOnes(fine) {
  const list = [];
  let last = fine;
  for (let cells = Math.pow(2, Math.floor(Math.log2(Math.sqrt(fine.place.length / 9)))); cells >= 2; cells /= 2) {
    const next = coarser(last, cells);
    if (!next.corner.length) break;
    if (next.corner.length < 0.6 * last.corner.length) list.push((last = next));
  }
  return list;
}

/* For three.js; vertices of the same point stand for themselves. */
function drawable(level) {
  const solid = new THREE.BufferGeometry(), line = new THREE.BufferGeometry(), position = new Float32Array(3 * level.of.length);
  level.of.forEach((i, v) => position.set(level.place.subarray(3 * i, 3 * i + 3), 3 * v));
  solid.setAttribute("position", new THREE.BufferAttribute(position, 3));
  solid.setAttribute("normal", new THREE.BufferAttribute(level.normal, 3));
  solid.setIndex(new THREE.BufferAttribute(level.corner, 1));
  line.setAttribute("position", new THREE.BufferAttribute(level.place, 3));
  line.setIndex(new THREE.BufferAttribute(new Uint32Array(level.pair), 1));
  return { solid, line, error: level.error };
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
let shapes = new Map(), shapesBefore = new Map(), shapeKeys = [];
whenScene(() => {
  [shapes, shapesBefore] = [new Map(), shapes];
  shapeKeys = data.geometries.map((one) => JSON.stringify(one));
});

/* {solid: all of its triangles, size, levels(): the finest first} */
function makeShape({ place, corner }) {
  let fine = finest(place, corner), levels = [drawable(fine)];
  const { solid } = levels[0], triangles = corner.length / 3;
  solid.boundingBox = new THREE.Box3().setFromArray(place);
  solid.boundingSphere = solid.boundingBox.getBoundingSphere(new THREE.Sphere());
  return { solid, line: levels[0].line, box: solid.boundingBox, sphere: solid.boundingSphere,
    /* The coarsest that is off by no more than that; those of few triangles for their size in it have no coarser ones. */
    levelFor: (most) => {
      if (fine && triangles * most * most > solid.boundingSphere.radius * solid.boundingSphere.radius) {
        levels.push(...coarserOnes(fine).map(drawable));
        fine = null;
      }
      let k = levels.length - 1;
      while (levels[k].error > most) k--;
      return k;
    },
    level: (k) => levels[k] };
}

/* Geometry g, made when its first object needs it. */
function shapeOf(g) {
  const key = shapeKeys[g];
  if (!shapes.has(key)) shapes.set(key, shapesBefore.get(key) || makeShape(triangles(data.geometries[g])));
  return shapes.get(key);
}
