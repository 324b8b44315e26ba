// SPDX-License-Identifier: MIT
//
// Where the panels stand, keys, and the start.

byId("stage").before(byId("left"));
byId("pane-tree").append(byId("objects-box"));
byId("objects-box").open = true;
byId("rays-box").before(byId("criteria-box"), byId("detector-box"));
byId("ray-box").before(byId("steps-box"), byId("histogram-box"));
document.querySelector("header").insertBefore(byId("bar"), byId("scheme").parentElement);
document.body.classList.add("workbench");

function showTab(name) {
  for (const one of ["tree", "text"]) {
    const own = one === name, tab = byId(`tab-${one}`);
    tab.setAttribute("aria-selected", String(own));
    tab.tabIndex = own ? 0 : -1;
    byId(`pane-${one}`).hidden = !own;
  }
  document.body.classList.toggle("writing", name === "text");
  if (name === "text") textEditor.refresh();
}
for (const [name, other] of [["tree", "text"], ["text", "tree"]]) {
  byId(`tab-${name}`).addEventListener("click", () => showTab(name));
  byId(`tab-${name}`).addEventListener("keydown", (event) => {
    if (event.key !== "ArrowLeft" && event.key !== "ArrowRight") return;
    event.preventDefault();
    showTab(other);
    byId(`tab-${other}`).focus();
  });
}

KEYS.unshift(
  ["r", "r", "trace, pause, go on", () => (live.state === "running" ? trace("pause") : live.state === "paused" ? trace("resume") : trace("start"))],
  ["e", "e", "write a criterion; Ctrl+Space completes, Ctrl+Enter shows its rays", () => criterionEditor.focus()],
  ["t", "t", "the scene's text; Ctrl+Enter applies it, Esc leaves it", () => {
    showTab("text");
    textEditor.focus();
  }],
  ["o", "o", "the scene's sources, detectors and objects", () => {
    showTab("tree");
    byId("find-object").focus();
  }],
  ["m", "m", "objects, sources and detectors are moved by dragging, or no longer", () => moveMode.click()],
  ["h", "h", "the histogram", () => {
    byId("histogram-box").open = true;
    byId("histogram-of").focus();
  }]);
const escape_ = KEYS.find(([name]) => name === "Escape"), escapeBefore = escape_[3];
escape_[3] = () => {
  if (dropObject(false)) return;
  if (byId("tip").hidden) escapeBefore();
  else hideTip();
};
byId("help").append(element("p", { textContent: "Editors by CodeMirror 5 (MIT licence), charts by d3 3.5 (BSD licence); the texts are in /library.js." }));
listKeys([["Ctrl+Z, Ctrl+Shift+Z", "edits of the scene undone, and done again"], ["Ctrl+S", "save the scene"]]);

document.addEventListener("keydown", (event) => {
  if (!event.ctrlKey && !event.metaKey) return;
  const key = event.key.toLowerCase(), call = key === "s" ? save : key !== "z" || event.target.matches("textarea, input") ? null
    : () => byId(event.shiftKey ? "edit-redo" : "edit-undo").click();
  if (!call) return;
  event.preventDefault();
  event.stopPropagation();
  call();
}, true);

TESTS.push(...firstNames.words.filter((word) => !TESTS.includes(word)));
showScene(firstScene);
live.places = {}; // it came with the model
showTrace(firstStatus.trace);
Object.assign(raymap, { moverAt });
raymap.live = () => ({ state: live.state, traced: live.traced, pictures: live.pictures.slice(), criteria: live.criteria.slice() });
if (renderer.compile) renderer.compile(world, camera); // or the first rays would wait for their shader
document.documentElement.dataset.workbench = "yes";
