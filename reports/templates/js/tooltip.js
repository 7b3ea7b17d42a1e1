// The tooltip beside the pointer, one for all figures.

import { make } from "./dom.js";

export const tooltip = make("div", { id: "tooltip", role: "status", hidden: true });

/** Show lines beside the pointer, the first in bold; hide the tooltip where there are none. */
export function showTooltip(lines, event) {
  tooltip.hidden = !lines;
  if (!lines) return;
  tooltip.replaceChildren(make("b", {}, lines[0]), ...lines.slice(1).map((line) => make("div", {}, line)));
  const { innerWidth } = window;
  const wide = tooltip.offsetWidth;
  tooltip.style.left = `${Math.min(event.clientX + 14, innerWidth - wide - 8)}px`;
  tooltip.style.top = `${event.clientY + 16}px`;
}
