// SPDX-License-Identifier: MIT
//
// The table of path classes; a click shows one of them alone.

/* "0.0168" and, small, "± 0.0015". */
function withError(value, error, unit = "") {
  const shownError = error === null ? "" : ` \u00b1 ${figure(error, 2)}`;
  return element("td", {}, figure(value, 4), element("small", { textContent: `${shownError}${unit}` }));
}

function classCells(one) {
  const factor = one.flux > 0 ? one.share / one.flux : 0; // the error of a share of all flux
  return [element("td", { textContent: whole(one.rays) }), withError(one.flux, one.standard_error),
    withError(100 * one.share, one.standard_error === null ? null : 100 * factor * one.standard_error, " %")];
}

function classRow(one, index) {
  const swatch = element("span", { className: "swatch" });
  scheme.own.push(() => (swatch.style.background = kindColour(index)));
  const button = element("button", { type: "button", title: "show only these" }, swatch, one.sequence);
  button.setAttribute("aria-pressed", "false");
  button.addEventListener("click", () => chooseClass(shown.class === index ? -1 : index));
  const row = element("tr", {}, element("td", {}, button), element("td", { textContent: whole(one.here) }), ...classCells(one));
  row.dataset.class = index;
  return row;
}

function restRow(rest) {
  const others = data.classes.count === null ? "all others" : `${whole(data.classes.count - classes.length)} others`;
  const here = ray.class.reduce((n, c) => n + (c < 0 ? 1 : 0), 0);
  return element("tr", { className: "rest" }, element("td", { textContent: others }),
    element("td", { textContent: whole(here) }), ...classCells(rest));
}

/* Rays of the page in each class, of those that the region and the criteria choose; where there is such a
 * choice, those with most flux first, and without the empty ones. */
function refreshClasses() {
  const filtered = shown.region !== null || !allCriteriaOn();
  const rays = new Uint32Array(classes.length + 1), flux = new Float64Array(classes.length + 1);
  for (let r = 0; r < ray.count; r++) {
    if ((shown.region && !shown.region[r]) || !isOn(r)) continue;
    const row = ray.class[r] < 0 ? classes.length : ray.class[r];
    rays[row] += 1;
    flux[row] += ray.flux[r];
  }
  const rows = classRows.slice(); // the rest stays last
  if (filtered) rows.sort((a, b) => (flux[b.dataset.class] - flux[a.dataset.class]) || (a.dataset.class - b.dataset.class));
  rows.forEach((row) => {
    const { class: index } = row.dataset;
    row.cells[1].textContent = whole(rays[index]);
    row.classList.toggle("none", filtered && rays[index] === 0 && Number(index) !== shown.class);
  });
  const body = byId("classes").tBodies[0];
  if (rows.some((row, k) => body.rows[k] !== row)) body.prepend(...rows); // moving takes the keyboard's place away
  if (data.classes.rest) body.rows[classes.length].cells[1].textContent = whole(rays[classes.length]);
  byId("classes-filter").textContent = filtered
    ? `${whole(rays.subarray(0, classes.length).filter((n) => n > 0).length)} of them have rays ${shown.region ? "in the region" : "of the criteria that are on"}, most flux first.` : "";
}

/* -1: all. */
function chooseClass(index) {
  shown.class = index;
  for (const row of byId("classes").tBodies[0].querySelectorAll("[data-class]")) {
    const own = Number(row.dataset.class) === index;
    row.classList.toggle("chosen", own);
    row.querySelector("button").setAttribute("aria-pressed", String(own));
  }
  showCriterion(byId("class-criterion"), index < 0 ? null : classes[index].criterion);
  if (marked.ray >= 0 && index >= 0 && ray.class[marked.ray] !== index) chooseRay(-1);
  refreshRays();
  refreshRegion();
}

const classRows = [];
whenData(() => {
  classRows.splice(0, classRows.length, ...classes.map(classRow));
  byId("classes").tBodies[0].replaceChildren(...classRows, ...(data.classes.rest ? [restRow(data.classes.rest)] : []));
  byId("classes-note").textContent = !classes.length ? "No ray, no class."
    : (data.classes.count === null ? "The largest classes" : `${whole(data.classes.count)} class${data.classes.count === 1 ? "" : "es"}`) +
      ` of the ${whole(data.matched)} matching rays, by ${data.classes.by}; flux in ${scene.flux_unit} with its standard error; ` +
      "here: rays in this page";
  showCriterion(byId("class-criterion"), null);
});
copyButton(byId("class-criterion"));

/* Items that have all the words typed. */
function searchIn(field, items) {
  field.addEventListener("input", () => {
    const typed = field.value.toLowerCase().split(/\s+/);
    for (const item of items()) item.hidden = !typed.every((word) => item.textContent.toLowerCase().includes(word));
  });
}
searchIn(byId("find-class"), () => byId("classes").tBodies[0].querySelectorAll("[data-class]"));

/* The criteria that were given: a switch each, and the colour of the rays that match it. */
function whereItem(one, index) {
  const box = element("input", { type: "checkbox", checked: Boolean(whereOn & (1 << index)) });
  const swatch = element("span", { className: "swatch" });
  scheme.own.push(() => (swatch.style.background = kindColour(index)));
  box.addEventListener("change", () => {
    whereOn = box.checked ? whereOn | (1 << index) : whereOn & ~(1 << index);
    refreshRays();
    paintRays();
    refreshRegion();
  });
  return element("li", {}, element("label", { title: one.criterion }, box, swatch, one.name || one.criterion,
    element("small", { textContent: ` ${whole(one.here)}` })));
}

const byCriterion = element("option", { value: "criterion", textContent: "by criterion" });
whenData(() => {
  byId("where").replaceChildren(...where.map(whereItem));
  byId("where").hidden = !where.length;
  if (where.length) byId("colour").append(byCriterion);
  else byCriterion.remove();
  if (!where.length && colouring.mode === "criterion") colouring.mode = "natural";
  byId("colour").value = colouring.mode;
});
