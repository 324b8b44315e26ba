// SPDX-License-Identifier: MIT
//
// Criteria from events: steps that are put one behind the other by clicks on objects and letters,
// and the tree of what happened to the light.

const steps_ = { list: [], letter: ".", tree: null, turn: inTurn() };

function stepsText() {
  const { list } = steps_;
  if (!list.length) return null;
  const end = /^[AX]/.test(list[list.length - 1]) ? " V*" : " .*";
  return `path("${list.join(" ").replaceAll('"', '\\"')}${list[list.length - 1] === ".*" ? "" : end}")`;
}

function showSteps() {
  byId("chips").replaceChildren(...steps_.list.map((text, index) => {
    const button = element("button", { type: "button", textContent: `${text} ✕`, title: "take this step away" });
    button.addEventListener("click", () => {
      steps_.list.splice(index, 1);
      showSteps();
    });
    return element("li", {}, button);
  }));
  showCriterion(byId("steps-criterion"), stepsText());
  byId("steps-count").textContent = steps_.list.length ? `${steps_.list.length} step${steps_.list.length > 1 ? "s" : ""}` : "";
}

/* name: of an object, group or detector, quoted where need be; null: anywhere. */
function addStep(letter, name) {
  steps_.list.push(letter === "." && name === null ? ".*" : name === null ? letter : `${letter}@${name}`);
  byId("steps-box").open = true;
  showSteps();
}

byId("letters").append(...LETTERS.map(([letter, meaning]) => {
  const button = element("button", { type: "button", textContent: letter, title: meaning });
  button.setAttribute("aria-label", meaning);
  button.setAttribute("aria-pressed", String(letter === steps_.letter));
  button.addEventListener("click", () => {
    steps_.letter = letter;
    for (const one of byId("letters").children) one.setAttribute("aria-pressed", String(one === button));
    listPlaces();
  });
  return button;
}));

/* Where the next step may be. */
function listPlaces() {
  const list = steps_.letter === "V" ? names().detector : steps_.letter === "X" ? [] : names().object;
  const chosen = byId("step-object").value;
  byId("step-object").replaceChildren(element("option", { value: "", textContent: steps_.letter === "." ? "any steps" : "anywhere" }),
    ...list.map((name) => element("option", { textContent: name })));
  if (list.includes(chosen)) byId("step-object").value = chosen;
}
byId("step-add").addEventListener("click", () => addStep(steps_.letter, byId("step-object").value || null));

/* A body that is clicked proposes what may be asked of it. */
bodyActions.push((index) => {
  const { name } = scene.objects[index], word = quoted(name);
  const act = (text, title, call) => {
    const button = element("button", { type: "button", textContent: text, title });
    button.addEventListener("click", () => {
      hideTip();
      call();
    });
    return button;
  };
  return [act("hit", "rays that meet it", () => addCriterion(`hit(${word})`)),
    act("reflect", "rays that it reflects", () => addCriterion(`hit(${word}, reflect)`)),
    act("add step", "as the next step of a path", () => addStep(steps_.letter === "V" || steps_.letter === "X" ? "." : steps_.letter, word)),
    act("move", "move it", () => chooseMover(moverOf(index)))];
});

/* "T@lens{2} V@'odd name'" as steps; what was left out ends them. */
function stepsOf(sequence) {
  const words = sequence.match(/(?:'(?:[^']|'')*'|[^ '])+/g) || [], cut = words.indexOf("...");
  return words.slice(0, cut < 0 ? words.length : cut).flatMap((word) => {
    const [, step, times_] = /^(.*)\{(\d+)\}$/.exec(word) || [null, word, 1];
    return Array(Number(times_)).fill(step);
  });
}

/* {flux, rays, next: Map from step to the same} of the classes of `paths`. */
function treeOf(classes) {
  const root = { flux: 0, rays: 0, next: new Map() };
  for (const { source, sequence, flux, rays } of classes) {
    let node = root;
    for (const step of [`source ${source}`, ...stepsOf(sequence)]) {
      if (!node.next.has(step)) node.next.set(step, { flux: 0, rays: 0, next: new Map() });
      node = node.next.get(step);
      node.flux += flux;
      node.rays += rays;
    }
  }
  return root;
}

function treeItems(node, before, total) {
  const rows = [...node.next].sort(([, a], [, b]) => b.flux - a.flux);
  return rows.map(([step, begin]) => {
    const own = [...before, step];
    let one = begin;
    while (one.next.size === 1 && before.length) { // what all of it did is one row
      const [[next, after]] = one.next;
      if (after.rays !== one.rays) break;
      own.push(next);
      one = after;
    }
    const share = total > 0 ? (100 * one.flux) / total : 0;
    const name = element("button", { type: "button", textContent: own.slice(before.length).join(" "), title: "rays whose light went so" });
    name.addEventListener("click", (event) => {
      event.preventDefault();
      const path = own.slice(1).join(" "), from = `source(${quoted(own[0].slice(7))})`;
      addCriterion(path ? `${from} and path("${path}${one.next.size ? " .*" : ""}")` : from);
    });
    const line = [name, element("small", { textContent: `${figure(share, 3)} %, ${whole(one.rays)} rays` })];
    if (!one.next.size) return element("li", {}, element("span", { className: "leaf" }, ...line));
    const folded = element("details", {}, element("summary", {}, ...line));
    folded.addEventListener("toggle", () => folded.open && folded.children.length === 1 &&
      folded.append(element("ul", {}, ...treeItems(one, own, total))));
    return element("li", {}, folded);
  });
}

async function showTree() {
  if (!byId("steps-box").open) return;
  const isLast = steps_.turn();
  try {
    const light = lit(), told = await ask("paths", { by: "surface", top: 500, ...(light ? { criterion: light } : {}) }), rest = told.remainder;
    if (!isLast()) return;
    const text = JSON.stringify(told.classes);
    if (text === steps_.tree) return; // what is unfolded stays so
    steps_.tree = text;
    byId("tree").replaceChildren(...treeItems(treeOf(told.classes), [], told.flux.value));
    if (rest && rest.rays) byId("tree").append(element("li", {}, element("small", { className: "leaf", textContent: `${figure(100 * rest.share, 3)} % in rarer ways` })));
  } catch (refused) {
    if (!isLast()) return;
    steps_.tree = null;
    byId("tree").textContent = refused.message;
  }
}
byId("steps-box").addEventListener("toggle", showTree);
whenScene(listPlaces);
whenData(showTree);
