// SPDX-License-Identifier: MIT
//
// The chosen ray and the leg under the pointer, as lines some pixels wide in front of everything.

function wideLines(width) {
  const uniforms = { ink: { value: new THREE.Color() }, size: { value: new THREE.Vector2(1, 1) }, width: { value: width } };
  const material = new THREE.ShaderMaterial({
    uniforms, transparent: true, depthTest: false, depthWrite: false, side: THREE.DoubleSide,
    vertexShader: `
      attribute vec3 other;
      attribute float side;
      uniform vec2 size;
      uniform float width;
      void main() {
        vec4 a = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        vec4 b = projectionMatrix * modelViewMatrix * vec4(other, 1.0);
        vec2 along = (b.xy / b.w - a.xy / a.w) * size;
        along = along / max(length(along), 1e-6);
        a.xy += vec2(-along.y, along.x) * side * width / size * a.w;
        gl_Position = a;
      }`,
    fragmentShader: `
      uniform vec3 ink;
      void main() { gl_FragColor = vec4(ink, 0.95); }`,
  });
  const mesh = new THREE.Mesh(new THREE.BufferGeometry(), material);
  mesh.frustumCulled = false;
  mesh.visible = false;
  mesh.renderOrder = 5;
  world.add(mesh);
  frames.before.push(() => uniforms.size.value.set(canvas.clientWidth, canvas.clientHeight));
  return mesh;
}

/* Strokes first to last - 1. */
function markStrokes(mesh, first, last) {
  const position = [], other = [], side = [], index = [];
  for (let s = first; s < last; s++) {
    const a = strokes.position.subarray(6 * s, 6 * s + 3), b = strokes.position.subarray(6 * s + 3, 6 * s + 6);
    const v = 4 * (s - first);
    position.push(...a, ...a, ...b, ...b);
    other.push(...b, ...b, ...a, ...a);
    side.push(1, -1, -1, 1);
    index.push(v, v + 1, v + 2, v + 2, v + 1, v + 3);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(position), 3));
  geometry.setAttribute("other", new THREE.BufferAttribute(new Float32Array(other), 3));
  geometry.setAttribute("side", new THREE.BufferAttribute(new Float32Array(side), 1));
  geometry.setIndex(index);
  mesh.geometry.dispose();
  mesh.geometry = geometry;
  mesh.visible = last > first;
  redraw();
}

const chosenMark = wideLines(2.2), hoverMark = wideLines(3.2);
const marked = { ray: -1, leg: -1 };
scheme.told.push(() => {
  chosenMark.material.uniforms.ink.value.set(scheme.dark ? "#ffffff" : "#111111");
  hoverMark.material.uniforms.ink.value.set(scheme.dark ? "#ffd24d" : "#d97706");
});

function markRay(r) {
  marked.ray = r;
  markStrokes(chosenMark, r < 0 ? 0 : strokes.first[ray.firstLeg[r]], r < 0 ? 0 : strokes.first[ray.firstLeg[r + 1]]);
}

function markLeg(l) {
  if (marked.leg === l) return;
  marked.leg = l;
  markStrokes(hoverMark, l < 0 ? 0 : strokes.first[l], l < 0 ? 0 : strokes.first[l + 1]);
}
