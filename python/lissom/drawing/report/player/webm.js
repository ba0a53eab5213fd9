// Writes films as WebM: encoded pictures with their times, in clusters that begin with a whole picture.
//
// Elements of EBML (RFC 8794) and Matroska (RFC 9559). All sizes and numbers take eight bytes, so that the table of clusters
// is as long before their places are known as afterwards.

/** Identifiers of elements. */
const ID = {
  header: 0x1a45dfa3, version: 0x4286, readVersion: 0x42f7, longestId: 0x42f2, longestSize: 0x42f3, type: 0x4282,
  typeVersion: 0x4287, typeReadVersion: 0x4285, segment: 0x18538067, info: 0x1549a966, scale: 0x2ad7b1, duration: 0x4489,
  muxer: 0x4d80, writer: 0x5741, tracks: 0x1654ae6b, track: 0xae, number: 0xd7, uid: 0x73c5, kind: 0x83, lacing: 0x9c,
  codec: 0x86, video: 0xe0, width: 0xb0, height: 0xba, cues: 0x1c53bb6b, cue: 0xbb, cueTime: 0xb3, cuePlaces: 0xb7, cueTrack: 0xf7,
  cuePlace: 0xf1, cluster: 0x1f43b675, clusterTime: 0xe7, block: 0xa3,
};

/** Nanoseconds of a unit of time: times are in milliseconds. */
const MILLISECOND = 1e6;
/** The kind of track that has pictures. */
const PICTURES = 1;
/** The only track, as a number of EBML in one byte; of a block, that its picture is whole. */
const TRACK = 0x81;
const IS_WHOLE = 0x80;

/** The whole file. @param pictures {time in milliseconds, isWhole, bytes}; the first is whole, and one in half a minute. */
export function webm({ codec, width, height, duration, pictures }) {
  const clusters = [];
  for (const picture of pictures) {
    if (picture.isWhole) clusters.push([]);
    clusters.at(-1).push(picture);
  }
  const written = clusters.map(cluster);
  const info = element("info", number("scale", MILLISECOND), float("duration", duration), text("muxer", "lissom"), text("writer", "lissom"));
  const track = element("track", number("number", 1), number("uid", 1), number("kind", PICTURES), number("lacing", 0),
    text("codec", codec), element("video", number("width", width), number("height", height)));
  const tracks = element("tracks", track);
  // Places of clusters are counted from the first byte in the segment.
  const cues = (first) => {
    let place = first;
    return element("cues", ...clusters.map(([{ time }], i) => {
      const cue = element("cue", number("cueTime", time), element("cuePlaces", number("cueTrack", 1), number("cuePlace", place)));
      place += size(written[i]);
      return cue;
    }));
  };
  const before = size(info) + size(tracks) + size(cues(0));
  const header = element("header", number("version", 1), number("readVersion", 1), number("longestId", 4), number("longestSize", 8),
    text("type", "webm"), number("typeVersion", 4), number("typeReadVersion", 2));
  return new Blob([header, element("segment", info, tracks, cues(before), ...written)].flat(), { type: "video/webm" });
}

function cluster(pictures) {
  const [{ time: start }] = pictures;
  return element("cluster", number("clusterTime", start), ...pictures.map(({ time, isWhole, bytes }) => {
    const since = time - start;
    return element("block", [new Uint8Array([TRACK, since >> 8, since & 255, isWhole ? IS_WHOLE : 0]), bytes]);
  }));
}

const size = (pieces) => pieces.reduce((sum, { byteLength }) => sum + byteLength, 0);

/** An element as pieces of bytes: its identifier, its size, and what is in it. */
function element(name, ...inner) {
  const pieces = inner.flat();
  const head = [];
  for (let id = ID[name]; id > 0; id = Math.floor(id / 256)) head.unshift(id % 256);
  const length = new DataView(new ArrayBuffer(8));
  length.setBigUint64(0, BigInt(size(pieces)));
  // The first bit says that eight bytes follow each other.
  length.setUint8(0, 1);
  return [new Uint8Array(head), new Uint8Array(length.buffer), ...pieces];
}

function number(name, value) {
  const bytes = new DataView(new ArrayBuffer(8));
  bytes.setBigUint64(0, BigInt(value));
  return element(name, [new Uint8Array(bytes.buffer)]);
}

function float(name, value) {
  const bytes = new DataView(new ArrayBuffer(8));
  bytes.setFloat64(0, value);
  return element(name, [new Uint8Array(bytes.buffer)]);
}

const text = (name, words) => element(name, [new TextEncoder().encode(words)]);
