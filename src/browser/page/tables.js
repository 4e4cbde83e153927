'use strict';

// Adds a table with headings. Cells are texts or elements. classOf(row) is optional.
surfit.addTable = (parent, heads, rows, classOf = () => '') => {
  const table = surfit.element('table', parent);
  const addRow = (place, tag, cells, className) => {
    const line = surfit.element('tr', place, { className });
    for (const cell of cells) surfit.element(tag, line).append(cell);
  };
  addRow(surfit.element('thead', table), 'th', heads, '');
  const body = surfit.element('tbody', table);
  for (const row of rows) addRow(body, 'td', row, classOf(row));
  return table;
};

// Rows [name, value] of a nested object. Nested names are joined by spaces.
surfit.flatten = (object, prefix = '') => Object.entries(object).flatMap(([key, value]) => (
  value !== null && typeof value === 'object' ? surfit.flatten(value, `${prefix}${key} `)
    : [[prefix + key, value]]));

surfit.cellText = (value, unknown = 'unknown') => {
  if (value === undefined) return '';
  if (value === null) return unknown;
  return String(typeof value === 'number' && !Number.isInteger(value) ? Number(value.toPrecision(6)) : value);
};

// Adds a table with a column per run and a row per name in objectOf(run). Rows with different values have the class
// `differs`.
surfit.addRunTable = (parent, runs, objectOf) => {
  const columns = runs.map((run) => new Map(surfit.flatten(objectOf(run))));
  const names = [...new Set(columns.flatMap((column) => [...column.keys()]))];
  surfit.addTable(parent, ['', ...runs.map((run) => run.label)],
    names.map((name) => [name, ...columns.map((column) => surfit.cellText(column.get(name)))]),
    ([, first, ...others]) => (others.some((cell) => cell !== first) ? 'differs' : 'same'));
};
