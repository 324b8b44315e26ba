// SPDX-License-Identifier: MIT
//
// Objects, sources and detectors are chosen, and moved by typing or dragging: changes of their `at`.

/* dropped: when the drag before is over. */
const moving = { name: null, dragging: null, dropped: null };

/* What the scene file calls the object: surfaces of a lens are moved with it. */
function moverOf(index) {
  const { name } = scene.objects[index];
  let mover = name;
  for (let g = scene.objects[index].parent; g >= 0; g = scene.groups[g].parent)
    if (name.startsWith(scene.groups[g].name + ".")) mover = scene.groups[g].name;
  return mover;
}

const isBelow = (index, name) => {
  if (scene.objects[index].name === name) return true;
  for (let g = scene.objects[index].parent; g >= 0; g = scene.groups[g].parent) if (scene.groups[g].name === name) return true;
  return false;
};

/* What is drawn of that name: bodies, or the outline of a source or detector. */
function thingsOf(name) {
  const own = bodies.filter((_, index) => isBelow(index, name));
  return own.length ? own : outlines.filter((one) => one.name === name);
}

/* Where the scene's text names it: the number of the line, -1 where it comes of a group or an array. */
function lineOf(name) {
  const lines = textEditor.getValue().split("\n"), section = Object.entries({ objects: thingsOf(name).some((one) => one.object),
    sources: scene.sources.some((one) => one.name === name), detectors: true }).find(([, own]) => own)[0];
  const names = new RegExp(`(^|[{,\\s])name:\\s*(["']?)${name.replace(/[^\w]/g, "\\$&")}\\2\\s*([,}#]|$)`);
  let at = null;
  return lines.findIndex((line) => {
    at = (/^(\w+):/.exec(line) || [null, at])[1];
    return at === section && names.test(line);
  });
}

/* null: none. */
function chooseMover(name) {
  if (name !== moving.name) for (const field of byId("move-fields").querySelectorAll("input")) field.value = "0";
  const own = name === null ? [] : thingsOf(name), known = own.length > 0 || detectors.some((one) => one.name === name);
  moving.name = name;
  byId("move-name").textContent = known ? name : "Nothing chosen";
  byId("move-text").hidden = !known;
  byId("move-hint").hidden = known;
  byId("move-fields").hidden = !own.length;
  if (!own.length) return void (byId("move-place").textContent = "");
  const centre = own.reduce((box, one) => box.union(one.box), new THREE.Box3()).getCenter(new THREE.Vector3());
  byId("move-place").textContent = `about ${centre.toArray().map((v) => figure(Math.abs(v) < 1e-9 * whereabouts.radius ? 0 : v, 5)).join(", ")} ${scene.unit}`;
}

byId("move-text").addEventListener("click", () => {
  const line = lineOf(moving.name);
  if (line < 0) return say(`The text has no ${moving.name} of its own: it comes of a group, an array or another file`);
  showTab("text");
  textEditor.setSelection({ line, ch: 0 }, { line, ch: textEditor.getLine(line).length });
  textEditor.focus();
});

const move = (name, by) => change("edit", { move: name, by, axes: "world" });

byId("move").addEventListener("submit", (event) => {
  event.preventDefault();
  const fields = [...byId("move-fields").querySelectorAll("input")];
  const by = fields.map((field) => Number(field.value.trim().replace(",", ".").replace(MINUS, "-")));
  const wrong = by.findIndex((value) => !Number.isFinite(value));
  if (wrong >= 0) return say(`"${fields[wrong].value}" is no number`);
  if (moving.name !== null && by.some((value) => value !== 0)) move(moving.name, by);
});

/* In the tree each has a button that chooses it, but for what bears an object's name. */
function moverButton(label) {
  const { object, group, other } = label.querySelector("input").dataset, name = object ? moverOf(Number(object)) : group || other;
  if (!name || (other && bodies.some((_, index) => isBelow(index, name)))) return;
  const button = element("button", { type: "button", textContent: "✥", className: "mover", title: `move ${name}` });
  button.setAttribute("aria-label", `move ${name}`);
  button.addEventListener("click", () => {
    chooseMover(name);
    const first = byId("move-fields").hidden ? byId("move-text") : byId("move-fields").querySelector("input");
    first.focus();
    if (first.select) first.select();
  });
  label.parentElement.insertBefore(button, label.nextSibling);
}
whenScene(() => {
  for (const label of byId("objects").querySelectorAll("label")) moverButton(label);
});
whenPlaced(() => chooseMover(moving.name));

/* Dragging: in the plane of the picture, on whole steps of the scale's hundredth. */
const moveMode = element("button", { type: "button", id: "move-mode", textContent: "move", title: "key m: drag objects, sources and detectors" });
moveMode.setAttribute("aria-pressed", "false");
toggle(moveMode, (on) => (canvas.style.cursor = on ? "move" : ""));
byId("views").append(moveMode);

function dragBy(event) {
  const [x, y] = placeOn(canvas, event), { from } = moving.dragging;
  const perPixel = (2 * halfHeight()) / Math.max(canvas.clientHeight, 1), step = roundLength(4 * perPixel);
  const right = new THREE.Vector3(1, 0, 0).applyQuaternion(camera.quaternion), up = new THREE.Vector3(0, 1, 0).applyQuaternion(camera.quaternion);
  const by = right.multiplyScalar((x - from[0]) * perPixel).addScaledVector(up, (from[1] - y) * perPixel);
  return by.toArray().map((value) => Number((Math.round(value / step) * step).toPrecision(9)) + 0);
}

/* The outline near a place on the canvas, or undefined. */
function outlineAt(x, y) {
  const caster = new THREE.Raycaster();
  caster.linePrecision = (REACH * 2 * halfHeight()) / Math.max(canvas.clientHeight, 1);
  caster.setFromCamera({ x: (2 * x) / canvas.clientWidth - 1, y: 1 - (2 * y) / canvas.clientHeight }, camera);
  const [hit] = caster.intersectObjects(outlines.filter(({ group }) => group.visible).map(({ group }) => group), true);
  return hit && outlines.find(({ group }) => group === hit.object.parent);
}

/* What can be dragged there; a thin outline goes before the body beside or behind it. */
function moverAt(x, y) {
  const outline = outlineAt(x, y), index = outline ? -1 : bodyAt(x, y);
  return outline ? outline.name : index < 0 ? null : moverOf(index);
}

const grab = (name) => thingsOf(name).map((thing) => ({ thing, matrix: thing.matrix.clone(), at: thing.label && thing.label.at.clone() }));

function putBy(things, by) {
  for (const { thing, matrix, at } of things) {
    const to = new THREE.Matrix4().makeTranslation(...by).multiply(matrix);
    if (thing.object) placeBody(thing, to);
    else thing.matrix.copy(to);
    if (at) thing.label.at.copy(at).add(vectorOf(by));
  }
  redraw();
}

canvas.addEventListener("pointerdown", (event) => {
  if (moveMode.getAttribute("aria-pressed") !== "true" || event.button !== 0) return;
  const from = placeOn(canvas, event), name = moverAt(...from);
  if (name === null) return;
  chooseMover(name);
  moving.dragging = { from, name, by: [0, 0, 0], things: grab(name), sent: [0, 0, 0], answer: null, refused: "", following: null };
  live.own++; // until it is dropped
  live.pace = DRAG_PACE;
  pace.held = true;
  controls.enabled = false;
  press.held = false;
});
window.addEventListener("pointermove", (event) => {
  const { dragging } = moving;
  if (!dragging) return;
  dragging.by = dragBy(event);
  stir();
  putBy(dragging.things, dragging.by);
  byId("move-place").textContent = `by ${dragging.by.map((v) => figure(v, 4)).join(", ")} ${scene.unit}`;
  follow(dragging);
});

/* The scene goes where the pointer is: one edit at a time, with the first rays of it; places that were left meanwhile are
 * skipped, the last one is not. All of it is one step of undo. */
function follow(dragging) {
  const isThere = () => String(dragging.by) === String(dragging.sent);
  const go = async () => {
    await moving.dropped;
    while (!isThere()) await step(dragging).catch(({ message }) => (dragging.refused = message));
    dragging.following = null;
  };
  if (!dragging.following && !isThere()) dragging.following = go();
  return dragging.following;
}

async function step(dragging) {
  dragging.sent = dragging.by;
  dragging.refused = "";
  const { answer } = dragging;
  await settling(async () => {
    dragging.answer = await ask("edit", { move: dragging.name, by: dragging.by, axes: "world", brief: true, ...(answer ? { amend: answer.revision } : {}) });
    reach(dragging.answer);
    await traceAgain();
  });
  if (dragging === moving.dragging) await want("rays", "detectors");
}

/* Where it is, or back where it was. */
async function drop(dragging, keep) {
  if (!keep) dragging.by = [0, 0, 0];
  if (dragging.by.every((v) => v === 0)) {
    putBy(dragging.things, dragging.by);
    dragging.sent = dragging.by;
    keep = false;
  }
  await follow(dragging);
  const { answer, refused } = dragging, isOurs = answer && live.heard <= answer.revision;
  if (answer && isOurs && keep) showScene(await ask("scene"));
  else if (answer && isOurs)
    await settling(async () => {
      showScene(await ask("undo"));
      await traceAgain();
    });
  if (answer || refused) await want("scene", "rays", "detectors");
  if (!moving.dragging) chooseMover(dragging.name);
  if (refused) say(refused);
}
whenPlaced(() => { // of the drag before
  const { dragging } = moving;
  if (dragging) putBy((dragging.things = grab(dragging.name)), dragging.by);
});

function dropObject(keep) {
  const { dragging } = moving;
  if (!dragging) return false;
  moving.dragging = null;
  controls.enabled = true;
  live.pace = PACE;
  moving.dropped = drop(dragging, keep).catch(({ message }) => say(message)).then(() => {
    live.own--;
    pace.held = moving.dragging !== null; // what comes with the drop need not wait for the full picture
    catchUp();
  });
  return true;
}
window.addEventListener("pointerup", () => dropObject(true));
window.addEventListener("pointercancel", () => dropObject(false));
