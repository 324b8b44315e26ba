// SPDX-License-Identifier: MIT
//
// Criteria: written, counted while they are written, and their rays shown in colours.

const criterionEditor = makeEditor(byId("criterion"), "criterion", { mode: "criterion", viewportMargin: Infinity,
  extraKeys: { "Ctrl-Space": (editor) => editor.showHint({ hint: completion, completeSingle: false }), "Ctrl-Enter": () => addCriterion(), "Cmd-Enter": () => addCriterion() } });

criterionEditor.on("inputRead", (editor, { text }) => {
  if (/^[\w.@'(,]$/.test(text[0])) editor.showHint({ hint: completion, completeSingle: false });
});

const MOST_CRITERIA = 31; // of a page

/* How many rays it has, or where it is wrong; whether it is right. */
async function countCriterion(text) {
  if (!text.trim()) {
    markMistakes(criterionEditor, []);
    byId("criterion-said").textContent = "";
    return false;
  }
  try {
    const { rays, flux } = await ask("query", { criterion: text });
    if (text !== criterionEditor.getValue()) return true;
    markMistakes(criterionEditor, []);
    const full = live.criteria.length >= MOST_CRITERIA && !live.criteria.includes(text);
    byId("criterion-said").className = full ? "wrong" : "";
    byId("criterion-said").textContent = full ? `${MOST_CRITERIA} criteria are shown, which is the most: take one away` : `${whole(rays.matched)} of ${whole(rays.total)} rays, ${figure(flux.matched, 5)} ± ${figure(flux.standard_error, 2)} ${flux.unit}`;
    return true;
  } catch (refused) {
    if (text !== criterionEditor.getValue()) return false;
    const { line, column } = refused.told;
    markMistakes(criterionEditor, [{ line, column, text: refused.message }]);
    byId("criterion-said").className = "wrong";
    byId("criterion-said").textContent = (line ? `${line}:${column}: ` : "") + refused.message;
    return false;
  }
}
const countLater = later(300, () => countCriterion(criterionEditor.getValue()));
criterionEditor.on("change", countLater);

/* Writes a criterion for the user. */
function proposeCriterion(text) {
  criterionEditor.setValue(text);
  byId("criteria-box").open = true;
}

function setCriteria(list) {
  if (!live.criteria.length && list.length) colouring.mode = "criterion";
  live.criteria = list;
  byId("criteria-count").textContent = list.length ? `${list.length} shown` : "";
  return want("rays", "detectors");
}

async function addCriterion(text = criterionEditor.getValue()) {
  criterionEditor.closeHint();
  if (text !== criterionEditor.getValue()) proposeCriterion(text);
  if (!(await countCriterion(text)) || live.criteria.includes(text)) return;
  if (live.criteria.length < MOST_CRITERIA) await setCriteria([...live.criteria, text]);
}

/* A ray by its number is drawn as those of a criterion; with new data the one whose name stands there is chosen. */
elsewhere.rays.push(async (id) => {
  const text = `ray == ${id}`, said = byId("ray-report");
  try {
    if ((await ask("query", { criterion: text })).rays.matched === 0) return void (said.textContent = "There is no such ray.");
  } catch (refused) {
    return void (said.textContent = refused.message);
  }
  byId("ray-name").textContent = id;
  await setCriteria([...live.criteria.filter((one) => one !== text).slice(0, MOST_CRITERIA - 1), text]);
});

/* Beside each switch: write it anew, and take it away. */
function editItem(item, index) {
  const text = where[index].criterion, act = (label, sign, call) => {
    const button = element("button", { type: "button", textContent: sign, title: label });
    button.setAttribute("aria-label", `${label}: ${text}`);
    button.addEventListener("click", call);
    return button;
  };
  item.append(act("write anew", "✎", () => {
    proposeCriterion(text);
    criterionEditor.focus();
  }), act("take away", "✕", () => setCriteria(live.criteria.filter((_, k) => k !== index))));
}
whenData(() => {
  [...byId("where").children].forEach(editItem);
  countLater();
});

/* Proposals of other panels: to be shown with a click. */
for (const box of document.querySelectorAll(".criterion")) {
  const use = element("button", { type: "button", textContent: "show" });
  use.addEventListener("click", () => addCriterion(box.querySelector("code").textContent));
  box.append(use);
}

byId("criterion-add").addEventListener("click", () => addCriterion());
byId("criterion-clear").addEventListener("click", () => setCriteria([]));
byId("ray-limit").addEventListener("change", (event) => {
  const limit = Number(event.target.value.replace(/[ ,_]/g, "")), MOST = 200000;
  const own = Number.isInteger(limit) && limit > 0 && limit <= MOST;
  if (own) asking.limit = limit;
  else say(`Rays drawn are a number from 1 to ${whole(MOST)}; "${event.target.value}" is none`);
  event.target.value = asking.limit;
  if (own) want("rays");
});
byId("criteria-box").append(byId("where")); // below the buttons, which stay where they are while it grows
