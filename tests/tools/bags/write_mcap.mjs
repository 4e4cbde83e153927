// Writes messages as an MCAP file, and prints them in CDR for other writers:
//   node write_mcap.mjs MESSAGES.json FILE.mcap [lz4|zstd|unchunked]
// MESSAGES.json is a list of {topic, type, time: [sec, nsec], message}; data are in base64.
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';

const require = createRequire(import.meta.url);
const { McapWriter } = require('@mcap/core');
const { parse } = require('@foxglove/rosmsg');
const { MessageWriter } = require('@foxglove/rosmsg2-serialization');

const header = 'std_msgs/Header header\n';
const separator = '\n================================================================================\n';
const headerDefinition = separator +
  'MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id' + separator +
  'MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n';
const definitions = {
  'sensor_msgs/msg/Image': header + 'uint32 height\nuint32 width\nstring encoding\n' +
    'uint8 is_bigendian\nuint32 step\nuint8[] data\n' + headerDefinition,
  'sensor_msgs/msg/CameraInfo': header + 'uint32 height\nuint32 width\nstring distortion_model\n' +
    'float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n' +
    'sensor_msgs/RegionOfInterest roi\n' + separator + 'MSG: sensor_msgs/RegionOfInterest\n' +
    'uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n' +
    headerDefinition,
  'tf2_msgs/msg/TFMessage': 'geometry_msgs/TransformStamped[] transforms\n' + separator +
    'MSG: geometry_msgs/TransformStamped\n' + header + 'string child_frame_id\n' +
    'geometry_msgs/Transform transform\n' + separator + 'MSG: geometry_msgs/Transform\n' +
    'geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n' + separator +
    'MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n' + separator +
    'MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n' + headerDefinition,
};

// A whole file in memory, as the writer wants it.
class Sink {
  parts = [];
  size = 0n;
  position() { return this.size; }
  async write(bytes) {
    this.parts.push(Buffer.from(bytes));
    this.size += BigInt(bytes.byteLength);
  }
}

const [input, output, how = ''] = process.argv.slice(2);
const compressChunk = how === 'lz4' || how === 'zstd' ? (bytes) => compress(how, bytes) : undefined;
function compress(compression, bytes) {
  // By the programs of that name: npm's compressors are others' wrappers of the same.
  const { execFileSync } = require('node:child_process');
  const options = compression === 'lz4' ? ['-c', '-z', '-'] : ['-c', '-'];
  return { compression,
    compressedData: execFileSync(compression, options, { input: bytes, maxBuffer: 1 << 30 }) };
}

const sink = new Sink();
const mcap = new McapWriter({ writable: sink, useChunks: how !== 'unchunked', compressChunk });
await mcap.start({ profile: 'ros2', library: 'write_mcap' });
const channels = new Map();
const cdr = [];
for (const { topic, type, time, message } of JSON.parse(readFileSync(input))) {
  if (!channels.has(topic)) {
    const text = definitions[type];
    const schemaId = await mcap.registerSchema(
      { name: type, encoding: 'ros2msg', data: new TextEncoder().encode(text) });
    const id = await mcap.registerChannel(
      { topic, schemaId, messageEncoding: 'cdr', metadata: new Map() });
    channels.set(topic, { id, writer: new MessageWriter(parse(text, { ros2: true })) });
  }
  const { id, writer } = channels.get(topic);
  if (message.data) message.data = Buffer.from(message.data, 'base64');
  const data = writer.writeMessage(message);
  const logTime = BigInt(time[0]) * 1000000000n + BigInt(time[1]);
  await mcap.addMessage({ channelId: id, sequence: 0, logTime, publishTime: logTime, data });
  cdr.push({ topic, type, log_time: logTime.toString(), data: Buffer.from(data).toString('base64') });
}
await mcap.end();
writeFileSync(output, Buffer.concat(sink.parts));
process.stdout.write(JSON.stringify(cdr));
