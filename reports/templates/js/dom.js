// Elements: text from a table always becomes text, never markup.

export const SVG = "http://www.w3.org/2000/svg";

/**
 * The element of page.html that has this id.
 * @param {string} id
 */
export function byId(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}

/** An HTML element with attributes (a function is a listener) and children (elements or text). */
export function make(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** The same for SVG. */
export function draw(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

export function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== ""));
  return element;
}

// Before printing, all that is still undrawn is drawn, and everything is drawn again at the paper's width and colours.
const awaitingView = new Set();

const repaints = new Set();

window.addEventListener("beforeprint", () => {
  document.documentElement.classList.add("printed");
  for (const { element, once } of awaitingView) if (element.getClientRects().length) once();
  for (const act of repaints) act();
});

window.addEventListener("afterprint", () => document.documentElement.classList.remove("printed"));

/** Call once, when an element first comes near the view. */
export function whenSeen(element, act) {
  const once = () => {
    if (!awaitingView.delete(waiting)) return;
    watcher.disconnect();
    act();
  };
  const waiting = { element, once };
  awaitingView.add(waiting);
  const watcher = new IntersectionObserver((entries) => entries.some((entry) => entry.isIntersecting) && once(), {
    rootMargin: "300px",
  });
  watcher.observe(element);
}

/** The value of a colour or font of the page's style. */
export function styleOf(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Call after the reader changes between light and dark. */
export function whenThemeChanges(act) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", act);
  repaints.add(act);
  window.addEventListener("afterprint", act);
}

export const reducedMotion = matchMedia("(prefers-reduced-motion: reduce)");
