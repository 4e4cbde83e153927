'use strict';
// Clicks and keys in the map.

// Calls `call` with the place, in CSS pixels from the element's top left, of a press that is neither long
// nor moves: others turn the map.
surfit.onClick = (element, call) => {
  const mostPx = 5, mostMs = 600;
  let down = null;
  element.addEventListener('pointerdown', (event) => {
    down = event.button === 0 ? { x: event.clientX, y: event.clientY, at: event.timeStamp } : null;
  });
  window.addEventListener('pointerup', (event) => {
    if (down && Math.hypot(event.clientX - down.x, event.clientY - down.y) <= mostPx
        && event.timeStamp - down.at <= mostMs) {
      const box = element.getBoundingClientRect();
      call(event.clientX - box.left, event.clientY - box.top);
    }
    down = null;
  });
};

// Turns the camera about its target by angles in radians: to the right about what is up, and upwards, but
// not over the top.
surfit.turnView = (view, right, upwards) => {
  const { camera, controls: { target } } = view;
  const offset = camera.position.clone().sub(target).applyAxisAngle(camera.up, right);
  const side = new THREE.Vector3().crossVectors(camera.up, offset).normalize();
  const raised = offset.clone().applyAxisAngle(side, -upwards);
  const fromTop = raised.angleTo(camera.up);
  view.look(target.clone().add(fromTop > 0.05 && fromTop < Math.PI - 0.05 ? raised : offset), target.clone());
};

surfit.moveView = (view, right, upwards) => {
  const { camera, controls: { target } } = view;
  const step = camera.position.distanceTo(target);
  const ahead = target.clone().sub(camera.position);
  const side = new THREE.Vector3().crossVectors(ahead, camera.up).normalize();
  const move = side.multiplyScalar(right * step).addScaledVector(camera.up, upwards * step);
  view.look(camera.position.clone().add(move), target.clone().add(move));
};

surfit.zoomView = (view, factor) => {
  const { camera, controls: { target } } = view;
  view.look(camera.position.clone().sub(target).multiplyScalar(factor).add(target), target.clone());
};

surfit.showNextFrame = (step) => {
  surfit.stepFrame(step);
  surfit.showMapFrame();
};

surfit.mapKeys = {
  ArrowLeft: (view, shift) => (shift ? surfit.moveView(view, -0.08, 0) : surfit.turnView(view, -0.12, 0)),
  ArrowRight: (view, shift) => (shift ? surfit.moveView(view, 0.08, 0) : surfit.turnView(view, 0.12, 0)),
  ArrowUp: (view, shift) => (shift ? surfit.moveView(view, 0, 0.08) : surfit.turnView(view, 0, 0.12)),
  ArrowDown: (view, shift) => (shift ? surfit.moveView(view, 0, -0.08) : surfit.turnView(view, 0, -0.12)),
  '+': (view) => surfit.zoomView(view, 0.85),
  '=': (view) => surfit.zoomView(view, 0.85),
  '-': (view) => surfit.zoomView(view, 1 / 0.85),
  n: () => surfit.showNextFrame(1),
  p: () => surfit.showNextFrame(-1),
  v: () => surfit.lookFromFrame(),
  m: (view) => view.turnMeasure(!view.measure.isOn()),
  Escape: (view) => view.turnMeasure(false),
  r: (view) => view.resetView(),
};

surfit.pressInMap = (view, event) => {
  const act = surfit.mapKeys[event.key];
  if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  act(view, event.shiftKey);
};
