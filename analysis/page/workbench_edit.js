// SPDX-License-Identifier: MIT
//
// Changes of the scene: its text, and objects that are moved by typing or dragging. Each is a
// change of the text that can be undone and saved.

const textEditor = makeEditor(byId("text"), "the scene's text", { mode: "yaml", lineNumbers: true,
  extraKeys: { "Ctrl-Enter": () => applyText(), "Cmd-Enter": () => applyText() } });
/* base: what the editor's text was made of */
const edited = { text: "", base: "", file: null, name: null, dragging: null };
whenData(() => edited.file && (byId("title").textContent = edited.file));

/* The server's text, number of steps and so on. */
function showScene({ text, file, revision, undo: past, redo: future, saved }) {
  live.revision = revision;
  const own = textEditor.getValue() !== edited.text;
  edited.text = text;
  edited.file = file;
  byId("title").textContent = document.title = file;
  if (!own || textEditor.getValue() === text) edited.base = text;
  if (!own && textEditor.getValue() !== text) {
    const { left, top } = textEditor.getScrollInfo();
    textEditor.setValue(text);
    textEditor.scrollTo(left, top);
  }
  byId("edit-undo").disabled = !past;
  byId("edit-redo").disabled = !future;
  byId("edit-save").disabled = saved;
  byId("edit-save").textContent = saved ? "saved" : "save";
  byId("edit-save").title = `${file}; Ctrl+S`;
  showTextState();
}

function showTextState() {
  const own = textEditor.getValue() !== edited.text;
  byId("text-apply").disabled = byId("text-revert").disabled = !own;
  byId("text-state").textContent = !own ? "" : edited.base === edited.text ? "changed, not yet applied"
    : "changed, and so was the scene since: apply takes that back, revert shows it";
}

function showMistakes(mistakes) {
  markMistakes(textEditor, mistakes);
  byId("text-mistakes").replaceChildren(...mistakes.map(({ line, column, text }) => {
    const go = element("button", { type: "button", textContent: (line ? `${line}:${column} ` : "") + text });
    go.addEventListener("click", () => {
      if (line) textEditor.setCursor(line - 1, column - 1);
      textEditor.focus();
    });
    return element("li", {}, go);
  }));
}

/* What was said of a text that is no longer there. */
function clearMistakes() {
  showMistakes([]);
  say("");
}

/* Lines of a file that the scene includes are counted from its own first, which stands further below. */
const errorsOf = (diagnostics) => diagnostics.filter((one) => one.severity === "error").map((one) => ({ ...one,
  line: one.line && one.line + (one.file ? textEditor.getValue().split("\n").indexOf(`--- # include: ${one.file}`) + 1 : 0) }));

const checkLater = later(400, async () => {
  const text = textEditor.getValue();
  if (text === edited.text) return clearMistakes();
  try {
    const { diagnostics } = await ask("check", { text });
    if (text !== textEditor.getValue()) return;
    showMistakes(errorsOf(diagnostics));
    if (!byId("text-mistakes").children.length) say("");
  } catch (refused) {
    if (text === textEditor.getValue()) showMistakes(mistakesOf(refused));
  }
});
textEditor.on("change", () => {
  showTextState();
  checkLater();
});

const mistakesOf = ({ message, told }) => told.diagnostics ? errorsOf(told.diagnostics) : (told.line ? [{ line: told.line, column: told.column, text: message }] : []);

/* A change of the scene by the server: what is shown follows, and as many rays as before are traced. */
async function change(command, words) {
  try {
    showScene(await ask(command, words));
    showMistakes([]);
    await renew();
    const { trace: told } = await ask("status"); // events of the trace before may still come in
    if (live.wished > 0 && told.rays === 0 && told.state === "none") await ask("trace", { action: "start", rays: live.wished });
    return true;
  } catch (refused) {
    say(refused.message);
    if (words && words.text !== undefined) showMistakes(mistakesOf(refused));
    return false;
  }
}

async function sceneChanged() {
  showScene(await ask("scene"));
  await renew();
}

async function renew() {
  const { trace: told } = await ask("status"), { wished } = live;
  if (told.rays === 0 && told.state === "none") showTrace(told);
  live.wished = wished;
  await want("scene", "rays", "detectors");
}

async function applyText() {
  const text = textEditor.getValue();
  return text === edited.text || change("edit", { text });
}

/* With the text that stands in the editor: a wrong one is not saved. */
async function save() {
  if (!(await applyText())) return;
  try {
    await ask("save", /\.ya?ml$/.test(edited.file) ? {} : { file: edited.file.replace(/^.*\/|\.raymap$/g, "") + ".yaml" }); // of a map: beside it
    showScene(await ask("scene"));
  } catch (refused) {
    say(refused.message);
  }
}

byId("text-apply").addEventListener("click", applyText);
byId("text-revert").addEventListener("click", () => {
  edited.base = edited.text;
  textEditor.setValue(edited.text);
  clearMistakes();
});
byId("edit-undo").addEventListener("click", () => change("undo"));
byId("edit-redo").addEventListener("click", () => change("redo"));
byId("edit-save").addEventListener("click", save);

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
const bodiesOf = (name) => bodies.filter((_, index) => isBelow(index, name));

/* null: none. */
function chooseMover(name) {
  if (name !== edited.name) for (const field of byId("move-fields").querySelectorAll("input")) field.value = "0";
  edited.name = name;
  const own = name === null ? [] : bodiesOf(name);
  byId("move-name").textContent = own.length ? name : "No object chosen";
  byId("move-fields").hidden = !own.length;
  byId("move-hint").hidden = own.length > 0;
  if (!own.length) return void (byId("move-place").textContent = "");
  const centre = own.reduce((box, body) => box.union(body.box), new THREE.Box3()).getCenter(new THREE.Vector3());
  byId("move-place").textContent = `about ${centre.toArray().map((v) => figure(Math.abs(v) < 1e-9 * whereabouts.radius ? 0 : v, 5)).join(", ")} ${scene.unit}`;
}

const move = (name, by) => change("edit", { move: name, by });

byId("move").addEventListener("submit", (event) => {
  event.preventDefault();
  const fields = [...byId("move-fields").querySelectorAll("input")];
  const by = fields.map((field) => Number(field.value.trim().replace(",", ".").replace(MINUS, "-")));
  const wrong = by.findIndex((value) => !Number.isFinite(value));
  if (wrong >= 0) return say(`"${fields[wrong].value}" is no number`);
  if (edited.name !== null && by.some((value) => value !== 0)) move(edited.name, by);
});

/* In the tree each object and group has a button that chooses it. */
function moverButton(label) {
  const row = label.parentElement, box = label.querySelector("input");
  const name = box.dataset.object ? moverOf(Number(box.dataset.object)) : label.querySelector("strong").textContent;
  const button = element("button", { type: "button", textContent: "✥", className: "mover", title: `move ${name}` });
  button.setAttribute("aria-label", `move ${name}`);
  button.addEventListener("click", () => {
    chooseMover(name);
    byId("move-fields").querySelector("input").focus();
    byId("move-fields").querySelector("input").select();
  });
  row.insertBefore(button, label.nextSibling);
}
whenData(() => {
  for (const label of byId("objects").querySelectorAll("label")) moverButton(label);
  chooseMover(edited.name);
});

/* Dragging: in the plane of the picture, on whole steps of the scale's hundredth. */
const moveMode = element("button", { type: "button", id: "move-mode", textContent: "move", title: "key m: drag objects" });
moveMode.setAttribute("aria-pressed", "false");
toggle(moveMode, (on) => (canvas.style.cursor = on ? "move" : ""));
byId("views").append(moveMode);

function dragBy(event) {
  const [x, y] = placeOn(canvas, event), { from } = edited.dragging;
  const perPixel = (2 * halfHeight()) / Math.max(canvas.clientHeight, 1), step = roundLength(4 * perPixel);
  const right = new THREE.Vector3(1, 0, 0).applyQuaternion(camera.quaternion), up = new THREE.Vector3(0, 1, 0).applyQuaternion(camera.quaternion);
  const by = right.multiplyScalar((x - from[0]) * perPixel).addScaledVector(up, (from[1] - y) * perPixel);
  return by.toArray().map((value) => Number((Math.round(value / step) * step).toPrecision(9)) + 0);
}

canvas.addEventListener("pointerdown", (event) => {
  if (moveMode.getAttribute("aria-pressed") !== "true" || event.button !== 0) return;
  const from = placeOn(canvas, event), index = bodyAt(...from);
  if (index < 0) return;
  const name = moverOf(index);
  chooseMover(name);
  edited.dragging = { from, name, by: [0, 0, 0], own: bodiesOf(name).map(({ group }) => ({ group, matrix: group.matrix.clone() })) };
  controls.enabled = false;
  press.held = false;
});
window.addEventListener("pointermove", (event) => {
  if (!edited.dragging) return;
  const by = (edited.dragging.by = dragBy(event));
  for (const { group, matrix } of edited.dragging.own)
    group.matrix.copy(new THREE.Matrix4().makeTranslation(...by).multiply(matrix));
  byId("move-place").textContent = `by ${by.map((v) => figure(v, 4)).join(", ")} ${scene.unit}`;
  redraw();
});
function dropObject(keep) {
  const { dragging } = edited;
  if (!dragging) return false;
  edited.dragging = null;
  controls.enabled = true;
  const put = () => {
    for (const { group, matrix } of dragging.own) group.matrix.copy(matrix);
    chooseMover(dragging.name);
    redraw();
  };
  if (!keep || dragging.by.every((v) => v === 0)) put();
  else move(dragging.name, dragging.by).then((done) => done || put());
  return true;
}
window.addEventListener("pointerup", () => dropObject(true));
window.addEventListener("pointercancel", () => dropObject(false));
