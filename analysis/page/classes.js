// SPDX-License-Identifier: MIT
//
// The table of path classes; a click shows one of them alone.

function classRow(one, index) {
  const swatch = element("span", { className: "swatch" });
  scheme.told.push(() => (swatch.style.background = kindColour(index)));
  const button = element("button", { type: "button", title: "show only these" }, swatch, one.sequence);
  button.setAttribute("aria-pressed", "false");
  button.addEventListener("click", () => chooseClass(shown.class === index ? -1 : index));
  const row = element("tr", {}, element("td", {}, button),
    element("td", { textContent: whole(one.rays) }),
    element("td", { textContent: figure(one.flux, 4) }),
    element("td", { textContent: `${figure(100 * one.share, 3)} %` }));
  row.dataset.class = index;
  return row;
}

/* -1: all. */
function chooseClass(index) {
  shown.class = index;
  for (const row of byId("classes").tBodies[0].rows) {
    const own = Number(row.dataset.class) === index;
    row.classList.toggle("chosen", own);
    row.querySelector("button").setAttribute("aria-pressed", String(own));
  }
  showCriterion(byId("class-criterion"), index < 0 ? null : allOf([data.criterion, classes[index].criterion]));
  if (marked.ray >= 0 && index >= 0 && ray.class[marked.ray] !== index) chooseRay(-1);
  refreshRays();
  refreshRegion();
}

byId("classes").tBodies[0].append(...classes.map(classRow));
byId("classes-note").textContent = !classes.length ? "No ray, no class."
  : `${whole(data.classes.count)} class${data.classes.count === 1 ? "" : "es"} among the ${whole(ray.count)} rays of this page` +
    (data.classes.count > classes.length ? `; the first ${classes.length} are listed` : "") +
    `; flux in ${scene.flux_unit}, share of these rays\u2019 flux`;
copyButton(byId("class-criterion"));
