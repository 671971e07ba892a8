import { html } from "htl";

// A table that scrolls within its own width and sorts by the column that is clicked.
// columns: {title, value(row), text(row)?, number?}; rows: any. `order` is {title, down} of the column it
// is sorted by, which a click changes; {} for as the rows come.
export function table(columns, rows, { caption, max = 200, order = {} } = {}) {
  const body = html`<tbody></tbody>`;
  const fill = (sorted) => {
    body.replaceChildren(
      ...sorted.slice(0, max).map(
        (row) => html`<tr>${columns.map((column) => html`<td class=${column.number ? "number" : ""}>${cell(column, row)}`)}`,
      ),
    );
  };
  const show = () => {
    columns.forEach((column, i) => {
      if (column.title === order.title) heads[i].setAttribute("aria-sort", order.down ? "descending" : "ascending");
      else heads[i].removeAttribute("aria-sort");
    });
    fill(ordered(columns, rows, order));
  };
  const heads = columns.map((column) => {
    const button = html`<button type="button">${column.title}</button>`;
    button.onclick = () => {
      order.down = order.title === column.title ? !order.down : Boolean(column.number);
      order.title = column.title;
      show();
    };
    return html`<th scope="col" class=${column.number ? "number" : ""}>${column.sorts === false ? column.title : button}`;
  });
  show();
  const rest = rows.length - max;
  return html`<div class="scroll" tabindex="0" role="region" aria-label=${caption ?? "Table"}><table>
    ${caption ? html`<caption>${caption}</caption>` : ""}
    <thead><tr>${heads}</tr></thead>
    ${body}
  </table></div>${rest > 0 ? html`<p class="note">… and ${rest} more</p>` : ""}`;
}

// The rows in the order of a column; those without a value last.
export function ordered(columns, rows, { title, down }) {
  const column = columns.find((one) => one.title === title);
  if (!column) return rows;
  return [...rows].sort((a, b) => compare(column.value(a), column.value(b), down ? -1 : 1));
}

function cell(column, row) {
  return column.text ? column.text(row) : column.value(row) ?? "–";
}

function compare(a, b, sign) {
  const missing = (value) => value === null || value === undefined || Number.isNaN(value);
  if (missing(a) || missing(b)) return missing(a) - missing(b);
  return a === b ? 0 : a < b ? -sign : sign;
}
