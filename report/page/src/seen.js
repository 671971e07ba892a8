// What is drawn late: when it is first seen, or when all of it is printed.

const waiting = new Set();

// Calls draw() once, when the element scrolls into view or drawEverything() is called.
export function whenSeen(element, draw) {
  const once = () => {
    if (!waiting.delete(once)) return;
    observer.disconnect();
    draw();
  };
  waiting.add(once);
  const observer = new IntersectionObserver((entries) => entries.some((entry) => entry.isIntersecting) && once(), { rootMargin: "400px" });
  observer.observe(element);
}

// Calls draw(width) for every width [pixels] that the element gets, and for the one it has when
// drawEverything() is called.
export function whenSized(element, draw) {
  let drawn = 0;
  const fit = (width) => {
    if (width <= 0 || Math.abs(width - drawn) < 4) return;
    drawn = width;
    draw(width);
  };
  fitted.push(() => fit(Math.floor(element.clientWidth)));
  new ResizeObserver(([entry]) => fit(Math.floor(entry.contentRect.width))).observe(element);
}

const fitted = [];

export function drawEverything() {
  for (const draw of [...waiting]) draw();
  for (const fit of fitted) fit();
}
