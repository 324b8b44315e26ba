// SPDX-License-Identifier: MIT
//
// The scene's tree: its sources and detectors beside its objects. The light of a source can be left
// out of all that is shown; since light adds up, the rest is that of a scene without the source.

function otherItem(properties, name, more, call) {
  const box = element("input", properties);
  box.dataset.other = name;
  box.addEventListener("change", () => call(box.checked));
  return element("li", {}, element("label", {}, box, name, element("small", { textContent: more })));
}

const sourceItem = ({ name, flux }) => otherItem({ type: "checkbox", checked: !live.off.has(name) }, name, `${figure(flux, 4)} ${scene.flux_unit}`, (on) => {
  live.off[on ? "delete" : "add"](name);
  showOutlines();
  want("rays", "detectors");
});

const detectorItem = ({ name, type }, index) => otherItem({ type: "radio", name: "chosen-detector" }, name, type === "plane" ? "" : type, () => {
  takeStep({ index, region: null });
  drawLive();
});

function showOutlines() {
  for (const { name, group } of outlines) group.visible = !live.off.has(name);
  redraw();
}

/* That of the image. */
function markDetector() {
  const box = byId("objects").querySelectorAll("[name=chosen-detector]")[sensor.index];
  if (box) box.checked = true;
}

whenScene(() => {
  const branch = (name, items) => (items.length ? [branchItem(name, items)] : []);
  const choice = branch("Detectors", detectors.map(detectorItem));
  for (const one of choice) one.querySelector("label").replaceWith(element("strong", { textContent: "Detectors" })); // one of them is shown
  byId("objects").replaceChildren(...branch("Sources", scene.sources.map(sourceItem)), ...choice, ...branch("Objects", [...byId("objects").children]));
  markDetector();
});
whenPlaced(showOutlines);
