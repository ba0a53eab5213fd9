// Hands files to the reader.

/** A name of a file for what belongs to the page: letters and digits of the words, with hyphens between them. */
export function nameOf(...words) {
  const plain = [document.title, ...words].map((text) => text.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, ""));
  return plain.filter(Boolean).join("-") || "lissom";
}

/** Save what a blob holds. */
export function save(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1e4);
}

/** The pixels of a canvas as PNG. */
export const png = (canvas) => new Promise((resolve, reject) => {
  canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("the picture is too large for this browser"))), "image/png");
});
