// SPDX-License-Identifier: MIT
//
// Changes of the scene's text, which can be undone and saved.

const textEditor = makeEditor(byId("text"), "the scene's text", { mode: "yaml", lineNumbers: true,
  extraKeys: { "Ctrl-Enter": () => applyText(), "Cmd-Enter": () => applyText() } });
/* base: what the editor's text was made of */
const edited = { text: "", base: "", file: null };
whenData(() => edited.file && (byId("title").textContent = edited.file));

/* The server's text, number of steps and so on. */
function showScene(answer) {
  const { text, file, undo: past, redo: future, saved } = answer;
  reach(answer);
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

/* A change of the scene by this page: what others changed meanwhile is shown behind it. */
async function changing(call) {
  live.own++;
  try {
    return await call();
  } finally {
    live.own--;
    catchUp();
  }
}

const PATIENCE = 300; // milliseconds, for the first rays: then what changed is shown without

/* What is shown follows, and as many rays as before are traced. */
const change = (command, words) => changing(async () => {
  let refused = null;
  const done = await settling(async () => {
    try {
      showScene(await ask(command, words));
    } catch (told) {
      say(told.message);
      if (words && words.text !== undefined) showMistakes(mistakesOf(told));
      return false;
    }
    showMistakes([]);
    refused = await Promise.race([traceAgain().catch(({ message }) => message), new Promise((end) => setTimeout(end, PATIENCE))]);
    return true;
  });
  if (done) await want("scene", "rays", "detectors");
  if (refused) say(refused);
  return done;
});

/* Others changed the scene. */
function catchUp() {
  if (live.own > 0 || live.heard <= live.revision) return;
  changing(async () => {
    showScene(await ask("scene"));
    const { told } = live, { trace: now } = await ask("status");
    if (told === live.told) showTrace(now);
    await want("scene", "rays", "detectors");
  }).catch(({ message }) => say(message));
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
