// Saving: tables as CSV, figures as SVG and PNG, all made in the browser.

import { SVG, draw, make, styleOf } from "./dom.js";
import { copyLinkButton } from "./state.js";

export function saveAs(name, blob) {
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function csvCell(value) {
  if (value === null || value === undefined) return "";
  const text = value === Infinity ? "inf" : value === -Infinity ? "-inf" : Number.isNaN(value) ? "nan" : String(value);
  const safe = typeof value === "string" && /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\n\r]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}

/** Rows of one table as its file has them. */
export function csvOf(list) {
  const columns = Object.keys(list[0] ?? {});
  return [columns, ...list.map((row) => columns.map((column) => row[column]))].map((line) => line.map(csvCell).join(",")).join("\n") + "\n";
}

/** A figure as a file of its own, on the page's background and in its font. */
function svgText(svg) {
  const copy = svg.cloneNode(true);
  const { width, height } = svg.viewBox.baseVal;
  copy.setAttribute("xmlns", SVG);
  copy.setAttribute("width", width);
  copy.setAttribute("height", height);
  copy.setAttribute("font-family", "system-ui, sans-serif");
  copy.prepend(draw("rect", { x: svg.viewBox.baseVal.x, y: svg.viewBox.baseVal.y, width, height, fill: styleOf("--paper") }));
  const bare = new XMLSerializer().serializeToString(copy);
  return bare.replace(/var\((--[\w-]+)\)/g, (_, name) => styleOf(name)).replaceAll("currentColor", styleOf("--ink"));
}

function saveSvg(svg, name) {
  saveAs(`${name}.svg`, new Blob([svgText(svg)], { type: "image/svg+xml" }));
}

function savePng(svg, name) {
  const { width, height } = svg.viewBox.baseVal;
  const picture = new Image();
  picture.onload = () => {
    const canvas = make("canvas", { width: 2 * width, height: 2 * height });
    canvas.getContext("2d").drawImage(picture, 0, 0, 2 * width, 2 * height);
    canvas.toBlob((blob) => saveAs(`${name}.png`, blob));
  };
  picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svgText(svg))}`;
}

/** The buttons of a figure: link, SVG, PNG. */
export function figureTools(id, svg) {
  return make(
    "div",
    { class: "tools" },
    copyLinkButton(id),
    make("button", { type: "button", "aria-label": `Save ${id} as SVG`, click: () => saveSvg(svg(), id) }, "SVG"),
    make("button", { type: "button", "aria-label": `Save ${id} as PNG`, click: () => savePng(svg(), id) }, "PNG"),
  );
}
