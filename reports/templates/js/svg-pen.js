// A pen with the methods of a canvas that writes SVG: the code that draws a moment also saves it.

import { draw } from "./dom.js";

export class SvgPen {
  constructor(width, height) {
    this.svg = draw("svg", { viewBox: `0 0 ${width} ${height}` });
    this.way = "";
    this.fillStyle = "#000";
    this.strokeStyle = "#000";
    this.lineWidth = 1;
    this.globalAlpha = 1;
    this.lineJoin = "miter";
    /** @type {number[]} */
    this.dashes = [];
  }

  beginPath() {
    this.way = "";
  }
  moveTo(x, y) {
    this.way += `M${x.toFixed(2)},${y.toFixed(2)}`;
  }
  lineTo(x, y) {
    this.way += `${this.way ? "L" : "M"}${x.toFixed(2)},${y.toFixed(2)}`;
  }
  closePath() {
    this.way += "Z";
  }

  /** A whole circle: no other arc is drawn. */
  arc(x, y, r) {
    this.way += `M${(x - r).toFixed(2)},${y.toFixed(2)}a${r},${r},0,1,0,${2 * r},0a${r},${r},0,1,0,${-2 * r},0Z`;
  }
  setLineDash(dashes) {
    this.dashes = dashes;
  }

  fill() {
    this.svg.append(draw("path", { d: this.way, fill: this.fillStyle, "fill-opacity": this.globalAlpha }));
  }
  stroke() {
    const dash = this.dashes.join(" ") || null;
    this.svg.append(draw("path", { d: this.way, fill: "none", stroke: this.strokeStyle, "stroke-width": this.lineWidth, "stroke-opacity": this.globalAlpha, "stroke-linejoin": this.lineJoin, "stroke-dasharray": dash }));
  }
}
