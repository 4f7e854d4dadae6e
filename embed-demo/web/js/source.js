// The bytes of a file, wherever they are.

/**
 * @param {string | URL | Response | ArrayBuffer | ArrayBufferView | Blob} source
 * @param {{ signal?: AbortSignal, onProgress?: (received: number, total: number | null) => void }} options
 * @returns {Promise<ArrayBuffer>} of the caller's alone
 */
export async function bytesOf(source, { signal, onProgress } = {}) {
  signal?.throwIfAborted();
  if (typeof source === "string" || source instanceof URL) {
    const found = fetch(source, { signal }).catch((error) => {
      throw signal?.aborted ? signal.reason : new Error(`${source}: ${error.message}`);
    });
    return received(await found, signal, onProgress);
  }
  if (source instanceof Response) return received(source, signal, onProgress);
  if (source instanceof Blob) return source.arrayBuffer();
  if (ArrayBuffer.isView(source)) {
    return new Uint8Array(source.buffer, source.byteOffset, source.byteLength).slice().buffer;
  }
  if (typeof source?.byteLength === "number") return new Uint8Array(source).slice().buffer;
  throw new TypeError("load: expected a URL, a Response, bytes or a Blob");
}

/** The body of a response, piece by piece. */
async function received(response, signal, onProgress) {
  const { ok, status, statusText, headers } = response;
  const url = response.url || "the response";
  if (!ok || !response.body) throw new Error(`${url}: ${status} ${statusText}`);
  // What is packed on the way has another length.
  const length = headers.has("content-encoding") ? null : headers.get("content-length");
  const total = length && Number(length);
  const reader = response.body.getReader();
  const stop = () => reader.cancel(signal.reason).catch(() => {});
  signal?.addEventListener("abort", stop, { once: true });
  const parts = [];
  let n = 0;
  try {
    for (;;) {
      const { done, value } = await reader.read();
      signal?.throwIfAborted();
      if (done) break;
      parts.push(value);
      n += value.length;
      onProgress?.(n, total);
    }
  } catch (error) {
    throw signal?.aborted ? signal.reason : new Error(`${url}: ${error.message}`);
  } finally {
    signal?.removeEventListener("abort", stop);
  }
  return new Blob(parts).arrayBuffer();
}
