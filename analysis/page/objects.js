// SPDX-License-Identifier: MIT
//
// The tree of groups and objects; boxes show and hide them.

function showBody(index, visible) {
  bodies[index].visible = visible;
  hidden[visible ? "delete" : "add"](scene.objects[index].name);
  redraw();
}

function objectItem(index) {
  const box = element("input", { type: "checkbox", checked: bodies[index].visible });
  box.dataset.object = index;
  box.addEventListener("change", () => showBody(index, box.checked));
  const object = scene.objects[index];
  return element("li", {}, element("label", {}, box, object.name, element("small", { textContent: object.surface || "" })));
}

/* Of a long list so many rows at a time, which are laid out when they come in sight. */
const CHUNK = 250, ROW = 21; // rows; pixels, about

function chunked(items) {
  if (items.length < 2 * CHUNK) return items;
  return Array.from({ length: Math.ceil(items.length / CHUNK) }, (_, k) => {
    const own = items.slice(k * CHUNK, (k + 1) * CHUNK), chunk = element("li", { className: "chunk", role: "none" }, element("ul", { role: "none" }, ...own));
    chunk.style.containIntrinsicSize = `auto ${ROW * own.length}px`;
    return chunk;
  });
}

/* What stands together, with a switch for all of it. */
function branchItem(name, items) {
  const box = element("input", { type: "checkbox", checked: true });
  const list = element("ul", {}, ...chunked(items));
  box.addEventListener("change", () => {
    for (const one of list.querySelectorAll("input"))
      if (one.checked !== box.checked) one.click();
  });
  return element("li", {}, element("label", {}, box, element("strong", { textContent: name })), list);
}

/* What lies below group `parent`, -1 for the top. */
function objectItems(parent) {
  const items = [];
  scene.groups.forEach((group, index) => {
    if (group.parent !== parent) return;
    const item = branchItem(group.name, objectItems(index));
    item.querySelector("input").dataset.group = group.name;
    items.push(item);
  });
  scene.objects.forEach((object, index) => object.parent === parent && items.push(objectItem(index)));
  return items;
}

whenScene(() => byId("objects").replaceChildren(...chunked(objectItems(-1))));
searchIn(byId("find-object"), () => byId("objects").querySelectorAll("li:not(.chunk)"));
byId("find-object").addEventListener("input", () => {
  for (const chunk of byId("objects").querySelectorAll(".chunk")) chunk.hidden = !chunk.querySelector("li:not([hidden])");
});
