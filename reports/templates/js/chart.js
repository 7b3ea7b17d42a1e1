// Charts in SVG: marks, labels at line ends, the resolution of the truth, and one cursor and highlight for all figures.

import { CONTESTANTS, CROSS, inkOf } from "./contestants.js";
import { draw, make, whenThemeChanges } from "./dom.js";
import { figure } from "./numbers.js";
import { figureTools } from "./save.js";
import { followHighlight, highlight, show, shown } from "./selection.js";
import { follow } from "./state.js";
import { showTooltip } from "./tooltip.js";

export const FONT = 12;
const LABEL_GAP = 14;

// A curve this many times above the plain ones leaves the chart, so that those stay distinguishable.
const HEADROOM = 300;

/** The width of labels beside a chart [px], at most 55 % of the chart's. */
export function roomFor(labels, width) {
  return Math.min(14 + 6.8 * Math.max(0, ...labels.map((label) => label.length)), 0.55 * width);
}

/**
 * A scale from values to pixels, with its ticks.
 * @param {Partial<Axis>} axis
 * @param {number[]} values
 * @param {number[]} pixels
 */
export function scale({ log }, [least, most], [from, to]) {
  const f = log ? Math.log10 : (value) => value;
  const [a, b] = [f(least), f(most)];
  const place = (value) => from + ((f(value) - a) / (b - a || 1)) * (to - from);
  const back = (pixel) => {
    const value = a + ((pixel - from) / (to - from)) * (b - a);
    return log ? 10 ** value : value;
  };
  return { place, back, ticks: log ? decades(a, b, Math.abs(to - from)) : evenly(a, b, Math.abs(to - from)) };
}

/**
 * Whether an axis has a place for a value.
 * @param {Axis} axis
 * @param {number} value
 */
function placeable({ log }, value) {
  return Number.isFinite(value) && (!log || value > 0);
}

function decades(a, b, pixels) {
  const every = Math.max(1, Math.ceil((b - a) / (pixels / 34)));
  const found = [];
  for (let power = Math.ceil(a - 1e-9); power <= b + 1e-9; power += 1) if (power % every === 0) found.push(10 ** power);
  return found;
}

function evenly(a, b, pixels) {
  const rough = (b - a) / Math.max(2, pixels / 80) || 1;
  const unit = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((times) => times * unit).find((size) => size >= rough) ?? 10 * unit;
  const found = [];
  for (let at = Math.ceil(a / step - 1e-9); at * step <= b + 1e-9 * step; at += 1) found.push(Number((at * step).toPrecision(12)));
  return found;
}

/** As many of the given ticks as there is room for, including the last. */
function thinned(ticks, pixels) {
  const every = Math.ceil(ticks.length / Math.max(1, Math.floor(pixels / 46)));
  return ticks.filter((_, at) => (ticks.length - 1 - at) % every === 0);
}

/**
 * Put a chart into host and keep it up to date.
 * @param {Element} host
 * @param {object} options
 * @param {string} options.id its address on the page
 * @param {string} options.label what it shows, for screen readers
 * @param {Axis} options.x
 * @param {Axis} options.y
 * @param {ChartSeries[]} options.series those of every contestant; the selected ones are drawn
 * @param {{ x: number, y: number }[]} [options.limit] resolution of the reference: errors below it are not meaningful
 * @param {(frame: any) => Element[]} [options.under] what is drawn behind the curves
 * @param {{ get: () => number, set: (x: number) => void } | null} [options.cursor]
 * @param {number} [options.height] at least [px]
 * @param {number[] | null} [options.range] ends of the x axis
 * @param {number} [options.most] upper end of the y axis at most; larger values are drawn there
 * @param {number[]} [options.within] values that the y axis has in any case
 * @param {() => Set<string>} [options.selected] the names of the selected contestants
 */
export function chart(host, { id, label, x, y, series: all, limit = [], under = () => [], cursor = null, height: least = 300, range = null, most = Infinity, within = [], selected = shown }) {
  const svg = draw("svg", { class: "chart", role: "group", "aria-label": label, id });
  const box = make("figure", { class: "chart-box" }, svg, figureTools(id, () => svg));
  host.append(box);
  let width = 0;
  let frame = null;
  const fadeOthers = followHighlight(svg);

  function render() {
    width = Math.max(280, Math.round(box.clientWidth));
    const names = selected();
    const drawn = all.filter((one) => names.has(one.name) && one.points.length);
    svg.replaceChildren();
    const height = Math.max(least, drawn.length * LABEL_GAP * 0.9 + 64); // every label has room
    const legend = legendOf(drawn.map((one) => one.name), width, 0.45, selected);
    svg.setAttribute("viewBox", `0 0 ${width} ${height + legend.below}`);
    const area = { left: 58, right: width - (legend.beside || 12), top: 24, bottom: height - 40 };
    frame = framed(drawn, area);
    svg.append(...axes(area));
    if (!drawn.length) {
      svg.append(draw("text", { x: (area.left + area.right) / 2, y: (area.top + area.bottom) / 2, "text-anchor": "middle", fill: "var(--soft)", "font-size": FONT + 1 }, "No contestant is shown: choose one above."));
      return;
    }
    const clip = `clip-${id}`;
    svg.append(draw("defs", {}, draw("clipPath", { id: clip }, draw("rect", { x: area.left, y: area.top - 4, width: area.right - area.left + 5, height: area.bottom - area.top + 5 }))));
    const inside = draw("g", { "clip-path": `url(#${clip})` });
    inside.append(...limitBand(area), ...under({ ...frame, area }));
    drawn.forEach((one, at) => inside.append(curve(one, at)));
    svg.append(inside);
    if (cursor) svg.append(draw("line", { class: "cursor", y1: area.top, y2: area.bottom, stroke: "var(--ink)", "stroke-width": 1 }));
    svg.append(...(legend.beside ? labels(drawn, area) : legend.draw(0, height + 8)));
    svg.append(draw("rect", { class: "touch", x: area.left, y: area.top, width: area.right - area.left, height: area.bottom - area.top, fill: "transparent" }));
    moveCursor();
    fadeOthers();
  }

  function framed(drawn, area) {
    const points = drawn.flatMap((one) => one.points);
    const plain = points.filter((point) => point.plain);
    const counted = plain.length ? plain : points;
    const xs = points.map((point) => point.x).filter((value) => placeable(x, value));
    const ys = counted.map((point) => point.y).concat(y.log ? limit.map((point) => point.y) : [], within).filter((value) => placeable(y, value));
    let [low, high] = ys.length ? [Math.min(...ys), Math.max(...ys)] : [1e-3, 1];
    const highest = Math.max(high, ...points.map((point) => point.y).filter(Number.isFinite));
    if (y.log) [low, high] = [low / 2, Math.min(Math.min(highest, high * HEADROOM) * 2, most)];
    else if (low === high) [low, high] = [low - 1, high + 1];
    else [low, high] = [low - 0.05 * (high - low), high + 0.05 * (high - low)];
    let [first, last] = range ?? (xs.length ? [Math.min(...xs), Math.max(...xs)] : [1e-3, 1]);
    if (x.log) [first, last] = [first / 1.5, last * 1.5];
    const [X, Y] = [scale(x, [first, last], [area.left, area.right]), scale(y, [low, high], [area.bottom, area.top])];
    if (x.ticks) X.ticks = thinned(x.ticks, area.right - area.left);
    if (y.ticks) Y.ticks = y.ticks.filter((value) => value >= low && value <= high);
    return { X, Y, low, high, first, last };
  }

  function axes(area) {
    const text = (attributes, words) => draw("text", { fill: "var(--soft)", "font-size": FONT, ...attributes }, words);
    const showX = x.show ?? ((value) => figure(value, 2));
    const found = [];
    for (const value of frame.Y.ticks) {
      const at = frame.Y.place(value);
      found.push(draw("line", { x1: area.left, x2: area.right, y1: at, y2: at, stroke: "var(--rule)", "stroke-width": 1 }));
      found.push(text({ x: area.left - 6, y: at + 4, "text-anchor": "end" }, (y.show ?? figure)(value)));
    }
    for (const value of frame.X.ticks) {
      const at = frame.X.place(value);
      found.push(draw("line", { x1: at, x2: at, y1: area.bottom, y2: area.bottom + 4, stroke: "var(--soft)" }));
      found.push(text({ x: at, y: area.bottom + 17, "text-anchor": "middle" }, showX(value)));
    }
    found.push(draw("line", { x1: area.left, x2: area.right, y1: area.bottom, y2: area.bottom, stroke: "var(--soft)" }));
    found.push(text({ x: (area.left + area.right) / 2, y: area.bottom + 34, "text-anchor": "middle" }, x.label));
    found.push(text({ x: 2, y: 12 }, y.label));
    return found;
  }

  function limitBand(area) {
    if (!limit.length || !y.log) return [];
    const edge = limit.map((point) => [frame.X.place(point.x), frame.Y.place(Math.max(point.y, frame.low))]);
    if (edge.length === 1) edge.push([area.right, edge[0][1]]);
    edge[0][0] = Math.min(edge[0][0], area.left);
    const line = edge.map((point) => point.map((value) => value.toFixed(1)).join(",")).join("L");
    return [
      draw("path", { d: `M${line}L${area.right},${area.bottom}L${area.left},${area.bottom}Z`, fill: "var(--ink)", "fill-opacity": 0.08 }),
      draw("path", { d: `M${line}`, fill: "none", stroke: "var(--ink)", "stroke-opacity": 0.4 }),
    ];
  }

  function placed(point) {
    return [frame.X.place(point.x), frame.Y.place(Math.min(Math.max(point.y, y.log ? frame.low / 100 : -Infinity), y.log ? frame.high * (Number.isFinite(most) ? 1 : 100) : Infinity))];
  }

  function curve(one, number) {
    const { hue, dash, mark: shape } = CONTESTANTS.get(one.name);
    const group = draw("g", { class: "curve", "data-name": one.name });
    const line = one.points.filter((point) => point.plain || !one.points.some((other) => other.plain));
    if (line.length > 1)
      group.append(
        draw("path", {
          class: "line",
          d: `M${line.map((point) => placed(point).map((value) => value.toFixed(1)).join(",")).join("L")}`,
          fill: "none",
          stroke: `var(${hue})`,
          "stroke-width": 1.8,
          "stroke-dasharray": dash,
          "stroke-linejoin": "round",
        }),
      );
    const every = Math.max(1, Math.ceil(one.points.length / (x.log ? 60 : 8)));
    one.points.forEach((point, at) => {
      const [px, py] = placed(point);
      if (point.low !== undefined && point.high > point.low)
        group.append(draw("path", { d: `M${frame.X.place(point.low).toFixed(1)},${py.toFixed(1)}H${frame.X.place(point.high).toFixed(1)}`, stroke: `var(${hue})`, "stroke-opacity": 0.6 }));
      // Curves that coincide show their marks in turns; a chart of runs shows every flagged or failed run.
      if ((one.points.length - 1 - at + number * Math.ceil(every / 3)) % every && (point.plain || !x.log)) return;
      const plain = point.plain ? { d: shape, ...inkOf(one.name) } : { d: CROSS, fill: "none", stroke: `var(${hue})`, "stroke-width": 0.5 };
      group.append(draw("path", { class: "point", transform: `translate(${px.toFixed(1)} ${py.toFixed(1)}) scale(3.4)`, ...plain }));
    });
    return group;
  }

  function labels(drawn, area) {
    const wanted = drawn
      .map((one) => ({ name: one.name, from: placed(one.points.findLast((point) => point.plain) ?? one.points.at(-1)) }))
      .map((one) => ({ ...one, at: Math.min(Math.max(one.from[1], area.top + 4), area.bottom) }))
      .sort((a, b) => a.at - b.at);
    spread(wanted, area);
    return wanted.map(({ name, from, at }) => {
      const begin = area.right + 8;
      return labelOf(
        name,
        selected,
        draw("path", { d: `M${Math.min(from[0] + 5, area.right + 4).toFixed(1)},${Math.min(Math.max(from[1], area.top), area.bottom).toFixed(1)}L${begin},${at.toFixed(1)}`, fill: "none", stroke: `var(${CONTESTANTS.get(name).hue})`, "stroke-opacity": 0.35 }),
        draw("path", { transform: `translate(${begin + 6} ${at.toFixed(1)}) scale(3.4)`, d: CONTESTANTS.get(name).mark, ...inkOf(name) }),
        draw("text", { x: begin + 14, y: (at + 4).toFixed(1), fill: "var(--ink)", "font-size": FONT - 0.5 }, name),
      );
    });
  }

  /** Push labels apart until none covers another, and back into the figure. */
  function spread(wanted, area) {
    const gap = Math.min(LABEL_GAP, (area.bottom - area.top + 20) / wanted.length);
    for (let at = 1; at < wanted.length; at += 1) wanted[at].at = Math.max(wanted[at].at, wanted[at - 1].at + gap);
    let floor = area.bottom + 24;
    for (let at = wanted.length - 1; at >= 0; at -= 1) {
      wanted[at].at = Math.min(wanted[at].at, floor);
      floor = wanted[at].at - gap;
    }
  }

  function moveCursor() {
    const line = svg.querySelector(".cursor");
    if (!line || !frame || !cursor) return;
    const at = frame.X.place(cursor.get());
    line.setAttribute("x1", at);
    line.setAttribute("x2", at);
  }

  /** The point nearest to the pointer, if it is near. */
  function nearest(event) {
    const area = svg.getBoundingClientRect();
    const factor = width / area.width;
    const [px, py] = [(event.clientX - area.left) * factor, (event.clientY - area.top) * factor];
    let best = null;
    const names = selected();
    for (const one of all) {
      if (!names.has(one.name)) continue;
      for (const point of one.points) {
        const [qx, qy] = placed(point);
        const apart = Math.hypot(px - qx, py - qy);
        if (apart < (best?.apart ?? 40)) best = { apart, point, name: one.name, px };
      }
    }
    return { best, px };
  }

  svg.addEventListener("pointermove", (event) => {
    if (!event.target.classList.contains("touch")) return;
    const { best, px } = nearest(event);
    highlight(best?.name ?? "");
    showTooltip(best ? [best.name, ...best.point.lines] : null, event);
    if (cursor && event.buttons) cursor.set(frame.X.back(px));
  });
  svg.addEventListener("pointerdown", (event) => {
    if (cursor && event.target.classList.contains("touch")) cursor.set(frame.X.back(nearest(event).px));
  });
  svg.addEventListener("pointerleave", () => {
    highlight("");
    showTooltip(null);
  });
  whenThemeChanges(render);
  new ResizeObserver(() => Math.round(box.clientWidth) !== width && box.clientWidth && render()).observe(box);
  follow(["show", "tol"], render);
  return { render, moveCursor };
}

/** A contestant's label in a figure: a press hides the contestant in all figures, a double press shows it alone. */
function labelOf(name, selected, ...children) {
  const group = draw(
    "g",
    {
      class: "label",
      "data-name": name,
      tabindex: "0",
      role: "button",
      "aria-label": `${name}: press to hide, shift-press to show alone`,
      cursor: "pointer",
      pointerenter: () => highlight(name),
      pointerleave: () => highlight(""),
      focus: () => highlight(name),
      blur: () => highlight(""),
      keydown: (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        event.shiftKey ? isolate(name) : hide(name, selected);
      },
      click: () => {
        clearTimeout(group.due);
        group.due = setTimeout(() => hide(name, selected), 230); // unless a second click follows
      },
      dblclick: () => {
        clearTimeout(group.due);
        isolate(name);
      },
    },
    children,
  );
  return group;
}

/**
 * Names with their marks: beside a figure of that width where they take no more than a share of it, else below it.
 * Returns the room they take there, and draw(x, y), which puts the first of them there.
 */
export function legendOf(names, width, share, selected = shown) {
  const wide = 34 + 6.4 * Math.max(8, ...names.map((name) => name.length));
  const beside = wide < share * width ? wide : 0;
  const columns = beside ? 1 : Math.max(1, Math.floor(width / wide));
  const place = (x, y, at) => [x + (at % columns) * wide, y + 18 * Math.floor(at / columns)];
  const entry = (name, x, y) =>
    labelOf(
      name,
      selected,
      draw("rect", { x, y: y - 9, width: wide - 8, height: 18, fill: "transparent" }),
      draw("path", { transform: `translate(${x + 8} ${y}) scale(3.4)`, d: CONTESTANTS.get(name).mark, ...inkOf(name) }),
      draw("text", { x: x + 17, y: y + 4, fill: "var(--ink)", "font-size": FONT - 0.5 }, name),
    );
  return {
    beside,
    below: beside ? 0 : 18 * Math.ceil(names.length / columns) + 4,
    height: beside ? 40 + 18 * names.length : 0,
    draw: (x, y) => names.map((name, at) => entry(name, ...place(x, y, at))),
  };
}

function hide(name, selected) {
  show([...selected()].filter((other) => other !== name));
  showTooltip(null);
}

function isolate(name) {
  show([name]);
}
