// SPDX-License-Identifier: MIT
//
// The histogram of a number of the rays, with the standard error of each bin (d3).

const CHART = { height: 210, left: 52, right: 10, top: 8, bottom: 34 };
const chart = { told: null, turn: inTurn() };

const numbersOf = () => [...firstNames.values,
  ...names().detector.flatMap((name) => ["x", "y", "angle", "optical_path"].map((what) => `${what}(${name})`)),
  ...names().object.slice(0, 100).map((name) => `hit(${name}, reflect)`)];
whenScene(() => byId("numbers").replaceChildren(...numbersOf().map((value) => element("option", { value }))));

/* [{name, edges, flux, error}] */
function groupsOf(told) {
  return (told.groups || [{ ...told, name: "" }]).filter((one) => one.histogram)
    .map(({ name, histogram }) => ({ name, edges: histogram.edges, flux: histogram.flux, error: histogram.standard_error }));
}

function drawChart() {
  const svg = d3.select("#histogram-chart");
  svg.selectAll("*").remove();
  svg.attr("height", 0);
  if (!chart.told || !byId("histogram-box").open) return;
  const groups = groupsOf(chart.told), width = Math.max(byId("histogram-chart").clientWidth || 380, 200);
  const log = byId("histogram-log").checked, all = groups.flatMap((one) => one.flux.map((f, k) => f + (one.error[k] || 0)));
  const most = d3.max(all) || 1, least = d3.min(groups.flatMap((one) => one.flux).filter((f) => f > 0)) || most / 10;
  const x = d3.scale.linear().domain(d3.extent(groups.flatMap((one) => one.edges))).range([CHART.left, width - CHART.right]);
  const y = (log ? d3.scale.log().domain([0.5 * least, 1.2 * most]).clamp(true) : d3.scale.linear().domain([0, 1.05 * most]))
    .range([CHART.height - CHART.bottom, CHART.top]);
  const up = (v) => y(log ? Math.max(v, 0.5 * least) : Math.max(v, 0));
  svg.attr("viewBox", `0 0 ${width} ${CHART.height}`).attr("height", CHART.height);
  groups.forEach((one, index) => {
    const ink = groups.length > 1 ? kindColour(index) : scheme.dark ? "#7db8f0" : "#0b5cad";
    const bin = (k) => [x(one.edges[k]), x(one.edges[k + 1])];
    const outline = one.flux.map((f, k) => `L${bin(k)[0]} ${up(f)}L${bin(k)[1]} ${up(f)}`).join("");
    svg.append("path").attr("class", "bins").attr("fill", groups.length > 1 ? "none" : ink).attr("stroke", ink)
      .attr("d", `M${bin(0)[0]} ${y.range()[0]}${outline}L${bin(one.flux.length - 1)[1]} ${y.range()[0]}`);
    svg.selectAll(null).data(one.flux).enter().append("line").attr("class", "error").attr("stroke", ink)
      .attr("x1", (f, k) => (bin(k)[0] + bin(k)[1]) / 2).attr("x2", (f, k) => (bin(k)[0] + bin(k)[1]) / 2)
      .attr("y1", (f, k) => up(f - (one.error[k] || 0))).attr("y2", (f, k) => up(f + (one.error[k] || 0)));
    if (one.name) svg.append("text").attr("class", "name").attr("x", width - CHART.right - 4).attr("y", CHART.top + 12 + 14 * index).attr("fill", ink).text(one.name);
  });
  const short = (v) => figure(v, 3);
  const axisY = d3.svg.axis().scale(y).orient("left").ticks(5).tickFormat(short);
  if (log) axisY.tickValues(y.ticks().filter((v) => /^1/.test(v.toExponential())));
  svg.append("g").attr("class", "axis").attr("transform", `translate(0,${CHART.height - CHART.bottom})`)
    .call(d3.svg.axis().scale(x).orient("bottom").ticks(6).tickFormat((v) => figure(v, 4)));
  svg.append("g").attr("class", "axis").attr("transform", `translate(${CHART.left},0)`).call(axisY);
  svg.append("text").attr("class", "label").attr("x", (CHART.left + width) / 2).attr("y", CHART.height - 3)
    .text(`${chart.told.of}${chart.told.unit && chart.told.unit !== "1" ? ` / ${chart.told.unit}` : ""}; ordinate: ${chart.told.flux ? chart.told.flux.unit : scene.flux_unit} per bin`);
}

async function askHistogram() {
  const of = byId("histogram-of").value.trim(), by = byId("histogram-by").value;
  const refused = !of ? "say of what, such as path_length" : by === "criterion" && !live.criteria.length ? "no criterion is shown: add some above" : null;
  const list = ofWhat(), any = list.map((text) => `(${text})`).join(" or "), isLast = chart.turn();
  try {
    if (refused) throw new Error(refused);
    const told = await ask("stats", { of, ...(by ? { by } : {}), ...(by === "criterion" ? { where: list } : any ? { where: any } : {}) });
    if (!isLast()) return;
    chart.told = told;
    const { mean, standard_deviation: sd, values, unit } = told;
    byId("histogram-said").className = "";
    byId("histogram-said").textContent = mean ? `mean ${figure(mean.value, 6)} ± ${figure(mean.standard_error, 2)}, standard deviation ${figure(sd.value, 4)} ${unit || ""}, ${whole(values)} values${live.criteria.length ? " of the criteria shown" : ""}${lit() ? " of sources that are on" : ""}` : "";
  } catch (refused) {
    if (!isLast()) return;
    chart.told = null;
    byId("histogram-said").className = "wrong";
    byId("histogram-said").textContent = refused.message;
  }
  drawChart();
}

byId("histogram").addEventListener("submit", (event) => {
  event.preventDefault();
  askHistogram();
});
byId("histogram-log").addEventListener("change", drawChart);
byId("histogram-box").addEventListener("toggle", () => (chart.told ? drawChart() : byId("histogram-box").open && askHistogram()));
scheme.told.push(drawChart);
whenData(() => byId("histogram-box").open && chart.told && askHistogram());
