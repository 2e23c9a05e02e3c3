// run_onnx.js MODEL: images of the frames on standard input, [reference, frames ...][208] floats, by an ONNX runtime
// of npm: onnxruntime-node, else onnxruntime-web, where NODE_PATH finds one (else exit code 77).
const fs = require("fs");

function runtime() {
  for (const name of ["onnxruntime-node", "onnxruntime-web"]) {
    try {
      return require(name);
    } catch (error) {
      if (error.code !== "MODULE_NOT_FOUND") console.error(name + ": " + error.message);
    }
  }
  process.exit(77);
}

async function main() {
  const ort = runtime();
  const bytes = fs.readFileSync(0);
  const numbers = new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  const model = fs.readFileSync(process.argv[2]);
  const session = await ort.InferenceSession.create(new Uint8Array(model));
  const feeds = {
    reference_voltages: new ort.Tensor("float32", numbers.slice(0, 208), [208]),
    voltages: new ort.Tensor("float32", numbers.slice(208), [numbers.length / 208 - 1, 208]),
  };
  const answer = (await session.run(feeds)).conductivity_change;
  if (answer.dims.join() !== [numbers.length / 208 - 1, 24, 24].join()) throw new Error("dims " + answer.dims);
  fs.writeSync(1, Buffer.from(answer.data.buffer, answer.data.byteOffset, answer.data.byteLength));
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
