'use strict';
// Namespace of the scripts and helpers for elements, for all pages.
const surfit = {};

// Creates an element. Appends it to the parent unless `parent` is null.
surfit.element = (tag, parent, properties = {}) => {
  const element = Object.assign(document.createElement(tag), properties);
  if (parent) parent.append(element);
  return element;
};

surfit.byId = (id) => document.getElementById(id);

// Calls `call` with the element after each event.
surfit.on = (id, event, call) => surfit.byId(id).addEventListener(event, ({ target }) => call(target));

surfit.say = (parent, textContent, className = 'note') => surfit.element('p', parent, { className, textContent });

surfit.addFigure = (parent, src, name, frame, note = '') => {
  const figure = surfit.element('figure', parent);
  surfit.element('img', figure, { src, alt: `${name} of frame ${frame}` });
  surfit.element('figcaption', figure, { textContent: name + note });
};

// Calls `build` once, before the element is visible or printed.
surfit.whenInSight = (element, build) => {
  const once = () => {
    observer.disconnect();
    window.removeEventListener('beforeprint', once);
    build();
  };
  const observer = new IntersectionObserver((entries) => {
    if (entries.some((entry) => entry.isIntersecting)) once();
  }, { rootMargin: '100px' });
  observer.observe(element);
  window.addEventListener('beforeprint', once);
};

// Returns the result of `make`, or null without WebGL.
surfit.withWebGl = (parent, make) => {
  try {
    return make();
  } catch (error) {
    surfit.say(parent, `No 3D view: this browser has no WebGL (${error.message}).`, 'failed');
    return null;
  }
};

// Removes the elements <script class="name"> and returns their objects.
surfit.takeData = (name) => [...document.querySelectorAll(`script.${name}`)].map((element) => {
  element.remove();
  return JSON.parse(element.textContent);
});

// Minimum and maximum of numbers; [0, 0] without numbers.
surfit.range = (values) => {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [0, 0];
};

// Map from keys to lists of items, in the order of the first items.
surfit.groupBy = (items, keyOf) => {
  const groups = new Map();
  for (const item of items) {
    const key = keyOf(item);
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(item);
  }
  return groups;
};
