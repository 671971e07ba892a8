// What `carillon serve` tells the page that it gave (docs/service.md).

const token = new URLSearchParams(location.search).get("token");

export const isServed = location.protocol.startsWith("http");

function address(path, query = {}) {
  const url = new URL(path, location.href);
  url.search = new URLSearchParams({ ...query, ...(token ? { token } : {}) });
  return url;
}

// A page may also be a file on another server: that has no news.
async function isService() {
  try {
    return (await (await fetch(address("v1/health"))).json()).ready === true;
  } catch (error) {
    return !(error instanceof SyntaxError); // away, or something else that is no JSON
  }
}

// Calls told(news) for all that comes, and connected(whether) whenever the connection is had or lost;
// none() where nothing will ever come.
export function listen({ told, connected, none }) {
  const again_ms = 5000;
  const begin = () => {
    const source = new EventSource(address("v1/events"));
    source.onopen = () => connected(true);
    source.onmessage = (event) => told(JSON.parse(event.data));
    source.onerror = async () => {
      connected(false);
      // Where it was refused the browser does not try again.
      if (source.readyState !== EventSource.CLOSED) return;
      if (await isService()) setTimeout(begin, again_ms);
      else none();
    };
  };
  begin();
}

// The samples that a build made last.
export async function newest(folder, count) {
  const reply = await fetch(address("v1/newest", { folder, count }));
  if (!reply.ok) throw new Error((await reply.json()).error.message);
  return (await reply.json()).samples;
}
