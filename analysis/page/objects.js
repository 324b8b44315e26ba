// SPDX-License-Identifier: MIT
//
// The tree of groups and objects; boxes show and hide them.

function showBody(index, visible) {
  bodies[index].group.visible = visible;
  hidden[visible ? "delete" : "add"](scene.objects[index].name);
  redraw();
}

function objectItem(index) {
  const box = element("input", { type: "checkbox", checked: bodies[index].group.visible });
  box.dataset.object = index;
  box.addEventListener("change", () => showBody(index, box.checked));
  const object = scene.objects[index];
  return element("li", {}, element("label", {}, box, object.name, element("small", { textContent: object.surface || "" })));
}

/* What stands together, with a switch for all of it. */
function branchItem(name, items) {
  const box = element("input", { type: "checkbox", checked: true });
  const list = element("ul", {}, ...items);
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

whenScene(() => byId("objects").replaceChildren(...objectItems(-1)));
searchIn(byId("find-object"), () => byId("objects").querySelectorAll("li"));
