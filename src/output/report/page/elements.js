'use strict';
// What the pages' scripts share, and how they make the elements of a page.
const surfit = {};

surfit.element = (tag, parent, properties = {}) => {
  const element = Object.assign(document.createElement(tag), properties);
  parent.append(element);
  return element;
};

surfit.byId = (id) => document.getElementById(id);

surfit.hideAll = (selector, hidden) => {
  for (const element of document.querySelectorAll(selector)) element.hidden = hidden;
};

// Calls `build` once, when the element is about to be seen, or printed.
surfit.whenInSight = (element, build) => {
  let observer = null;
  const once = () => {
    observer.disconnect();
    window.removeEventListener('beforeprint', once);
    build();
  };
  observer = new IntersectionObserver((entries) => {
    if (entries.some((entry) => entry.isIntersecting)) once();
  }, { rootMargin: '100px' });
  observer.observe(element);
  window.addEventListener('beforeprint', once);
};
