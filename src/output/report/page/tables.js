'use strict';
// The summaries and options of all runs, a column each; rows that differ are marked.

// Rows of a nested object: names joined by spaces.
surfit.flatten = (object, prefix = '') => Object.entries(object).flatMap(([key, value]) => (
  value !== null && typeof value === 'object' ? surfit.flatten(value, `${prefix}${key} `)
    : [[prefix + key, value]]));

surfit.cellText = (value) => {
  if (value === undefined) return '';
  if (value === null) return 'unknown';
  return typeof value === 'number' && !Number.isInteger(value) ? String(Number(value.toPrecision(6)))
    : String(value);
};

surfit.addTable = (parent, runs, objects) => {
  const columns = objects.map((object) => new Map(surfit.flatten(object)));
  const names = new Set(columns.flatMap((column) => [...column.keys()]));
  const table = surfit.element('table', parent);
  const head = surfit.element('tr', surfit.element('thead', table));
  surfit.element('th', head);
  for (const run of runs) surfit.element('th', head, { textContent: run.label });
  const body = surfit.element('tbody', table);
  for (const name of names) {
    const cells = columns.map((column) => surfit.cellText(column.get(name)));
    const row = surfit.element('tr', body, {
      className: cells.some((cell) => cell !== cells[0]) ? 'differs' : 'same' });
    surfit.element('td', row, { textContent: name });
    for (const cell of cells) surfit.element('td', row, { textContent: cell });
  }
  return table;
};

surfit.showTables = (runs) => {
  surfit.addTable(surfit.byId('summary-table'), runs, runs.map(({ summary }) => {
    const { options, ...rest } = summary;
    return rest;
  }));
  const table = surfit.addTable(surfit.byId('options-table'), runs, runs.map((run) => run.summary.options));
  const only = surfit.byId('only-differing');
  const apply = () => {
    for (const row of table.querySelectorAll('tr.same')) row.hidden = only.checked;
  };
  surfit.byId('differing-label').hidden = runs.length < 2;
  only.addEventListener('change', apply);
  apply();
};
