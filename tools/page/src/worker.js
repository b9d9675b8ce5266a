// Runs the models beside the page, so that the page answers while they compute.
let models;
// A promise that fails raises no error of the worker, and the page would go on waiting: it is thrown again outside of the promise.
onmessage = ({ data }) => answer(data).catch((error) => setTimeout(() => { throw error; }));

async function answer(data) {
  if (data.wasm) {
    const bytes = Uint8Array.from(atob(data.wasm), (c) => c.charCodeAt(0));
    models = (await WebAssembly.instantiate(bytes, {})).instance.exports;
    postMessage({ ready: true });
    return;
  }
  const begin = performance.now();
  const request = new TextEncoder().encode(JSON.stringify(data.request));
  const at = models.reserve(request.length);
  new Uint8Array(models.memory.buffer, at, request.length).set(request);
  const length = models.answer();
  const text = new TextDecoder().decode(new Uint8Array(models.memory.buffer, models.text(), length));
  postMessage({ turn: data.turn, question: data.request.question, answer: JSON.parse(text), seconds: (performance.now() - begin) / 1000 });
}
