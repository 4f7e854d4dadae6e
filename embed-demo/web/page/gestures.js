// Gestures on an element, as turns, shifts and zooms of a view.

/** Largest movement of a click, pixels. */
const CLICK = 4;

/**
 * @param {HTMLElement} element
 * @param {{turn(x, y): void, shift(x, y): void, approach(factor): void, click(x, y): void,
 *   reset(): void}} view receives CSS pixels
 */
export function watch(element, view) {
  const hands = new Map();
  let moved = 0;

  const middle = () => {
    const all = [...hands.values()];
    const [x, y] = ["x", "y"].map((axis) => all.reduce((sum, p) => sum + p[axis], 0) / all.length);
    const apart = all.length > 1 ? Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) : 0;
    return { x, y, apart };
  };

  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    hands.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (hands.size === 1) moved = 0;
  });
  element.addEventListener("pointermove", (event) => {
    if (!hands.has(event.pointerId)) return;
    const before = middle();
    hands.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const after = middle();
    const [x, y] = [after.x - before.x, after.y - before.y];
    moved += Math.abs(x) + Math.abs(y) + Math.abs(after.apart - before.apart);
    if (hands.size > 1) {
      view.shift(x, y);
      if (before.apart > 0 && after.apart > 0) view.approach(before.apart / after.apart);
    } else if (event.buttons & 6 || event.shiftKey) view.shift(x, y);
    else view.turn(x, y);
  });
  const gone = (event) => {
    const was = hands.size;
    hands.delete(event.pointerId);
    const isClick = event.type === "pointerup" && was === 1 && moved <= CLICK && event.button === 0;
    if (isClick) view.click(event.offsetX, event.offsetY);
  };
  element.addEventListener("pointerup", gone);
  element.addEventListener("pointercancel", gone);
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      // Lines and pages as pixels; a pinch on a touch pad has small deltas.
      const pixels = event.deltaY * [1, 30, 300][event.deltaMode] * (event.ctrlKey ? 6 : 1);
      view.approach(Math.exp(0.0012 * Math.min(Math.max(pixels, -400), 400)));
    },
    { passive: false },
  );
  const keys = {
    ArrowLeft: () => view.turn(40, 0),
    ArrowRight: () => view.turn(-40, 0),
    ArrowUp: () => view.turn(0, 40),
    ArrowDown: () => view.turn(0, -40),
    "+": () => view.approach(1 / 1.15),
    "=": () => view.approach(1 / 1.15),
    "-": () => view.approach(1.15),
    Home: () => view.reset(),
  };
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
}
