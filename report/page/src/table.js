import { html } from "htl";

// A table that scrolls within its own width and sorts by the column that is clicked.
// columns: {title, value(row), text(row)?, number?}; rows: any.
export function table(columns, rows, { caption, max = 200 } = {}) {
  const body = html`<tbody></tbody>`;
  const fill = (sorted) => {
    body.replaceChildren(
      ...sorted.slice(0, max).map(
        (row) => html`<tr>${columns.map((column) => html`<td class=${column.number ? "number" : ""}>${cell(column, row)}`)}`,
      ),
    );
  };
  let sortedBy = null;
  let down = false;
  const heads = columns.map((column) => {
    const button = html`<button type="button">${column.title}</button>`;
    const head = html`<th scope="col" class=${column.number ? "number" : ""}>${button}`;
    button.onclick = () => {
      down = sortedBy === column ? !down : Boolean(column.number);
      sortedBy = column;
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      fill([...rows].sort((a, b) => (down ? -1 : 1) * compare(column.value(a), column.value(b))));
    };
    return head;
  });
  fill(rows);
  const rest = rows.length - max;
  return html`<div class="scroll" tabindex="0" role="region" aria-label=${caption ?? "Table"}><table>
    ${caption ? html`<caption>${caption}</caption>` : ""}
    <thead><tr>${heads}</tr></thead>
    ${body}
  </table></div>${rest > 0 ? html`<p class="note">… and ${rest} more</p>` : ""}`;
}

function cell(column, row) {
  return column.text ? column.text(row) : column.value(row) ?? "–";
}

function compare(a, b) {
  if (a === b) return 0;
  if (a === null || a === undefined) return 1;
  if (b === null || b === undefined) return -1;
  return a < b ? -1 : 1;
}
