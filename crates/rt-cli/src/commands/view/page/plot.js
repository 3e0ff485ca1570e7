// Error plot: relative error against samples per pixel, both logarithmic.

const SVG = "http://www.w3.org/2000/svg";
const HEIGHT = 150;
const MARGIN = { left: 40, right: 10, top: 8, bottom: 20 };

function element(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

/** Percentage with two digits that count. */
export function percent(share) {
  const value = 100 * share;
  if (value === 0) return "0 %";
  if (value < 0.001) return value.toExponential(1) + " %";
  return (value < 100 ? Number(value.toPrecision(2)) : Math.round(value)) + " %";
}

/** Values 1, 2, 5 times powers of ten within the range, or powers alone if there are many of them. */
function ticks(low, high, most) {
  const found = (digits) => {
    const values = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power += 1) {
      for (const digit of digits) {
        const value = digit * 10 ** power;
        if (value >= low * 0.999 && value <= high * 1.001) values.push(value);
      }
    }
    return values;
  };
  const fine = found([1, 2, 5]);
  if (fine.length <= most) return fine;
  const coarse = found([1]);
  const step = Math.ceil(coarse.length / most);
  return coarse.filter((_, index) => index % step === 0);
}

/** Powers of two, which samples are counted in. */
function powersOfTwo(low, high, most) {
  const values = [];
  for (let value = 2 ** Math.ceil(Math.log2(low)); value <= high; value *= 2) values.push(value);
  const step = Math.ceil(values.length / most);
  return values.filter((_, index) => index % step === 0);
}

/** Draws points `[samples, error, low, high]`; `empty` is shown if there are none. */
export function drawPlot(svg, points, empty) {
  const width = svg.clientWidth || 280;
  svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
  svg.replaceChildren();
  const drawn = points.filter(([, error, low, high]) => error > 0 && low > 0 && Number.isFinite(high));
  if (drawn.length === 0) {
    const middle = { x: width / 2, y: HEIGHT / 2, "text-anchor": "middle" };
    svg.append(element("text", middle, points.length > 0 ? "There is no error: all passes are the same." : empty));
    return;
  }
  const first = drawn[0][0];
  const last = Math.max(drawn.at(-1)[0], 2 * first);
  const lowest = Math.min(...drawn.map((point) => point[2]));
  const highest = Math.max(...drawn.map((point) => point[3]));
  const [low, high] = highest < 2 * lowest ? [lowest / 1.5, highest * 1.5] : [lowest / 1.1, highest * 1.1];
  const scale = (value, from, to, start, end) => start + (end - start) * (Math.log(value / from) / Math.log(to / from));
  const x = (samples) => scale(samples, first, last, MARGIN.left, width - MARGIN.right);
  const y = (error) => scale(error, low, high, HEIGHT - MARGIN.bottom, MARGIN.top);
  const path = (pairs) => pairs.map(([a, b], index) => `${index ? "L" : "M"}${x(a).toFixed(1)} ${y(b).toFixed(1)}`).join("");

  for (const error of ticks(low, high, 5)) {
    svg.append(element("line", { class: "grid", x1: MARGIN.left, x2: width - MARGIN.right, y1: y(error), y2: y(error) }));
    svg.append(element("text", { x: MARGIN.left - 6, y: y(error) + 4, "text-anchor": "end" }, percent(error)));
  }
  for (const samples of powersOfTwo(first, last, 6)) {
    svg.append(element("text", { x: x(samples), y: HEIGHT - 5, "text-anchor": "middle" }, samples));
  }
  const [samples, error] = drawn.at(-1);
  const slope = [first, last].map((at) => [at, error * Math.sqrt(samples / at)]);
  const clip = element("clipPath", { id: "plot-area" });
  const area = { x: MARGIN.left, y: MARGIN.top, width: width - MARGIN.left - MARGIN.right, height: HEIGHT - MARGIN.top - MARGIN.bottom };
  clip.append(element("rect", area));
  const upper = drawn.map(([at, , , to]) => [at, to]);
  const lower = drawn.map(([at, , from]) => [at, from]).reverse();
  svg.append(clip);
  svg.append(element("path", { class: "slope", d: path(slope), "clip-path": "url(#plot-area)" }));
  svg.append(element("path", { class: "band", d: path([...upper, ...lower]) + "Z" }));
  svg.append(element("path", { class: "line", d: path(drawn) }));
  svg.append(element("circle", { class: "dot", cx: x(samples), cy: y(error), r: 3 }));
}
