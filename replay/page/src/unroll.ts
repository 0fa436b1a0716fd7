// Where the taxels of a patch lie on its flat map.

import type { Reach } from "./reach.ts";
import { cross, rotate, type Triple, triple } from "./series.ts";

/** A taxel on the map: its middle and its side, in a unit common to the map. */
export interface Cell {
  taxel: number;
  x: number;
  y: number;
  size: number;
}

export interface Plan {
  cells: Cell[];
  width: number;
  height: number;
  /** Whether its upper end is clearly nearer to the tip of the arm, by a tenth of its length or more, in the first frame. */
  upwards: boolean;
  /** Whether the map shows two sides, side by side. */
  twoSides: boolean;
}

/** Lays out a patch with the end that is nearer to the tip at the top: a grid by rows and columns, other taxels as they lie on both sides. */
export function layOut(reach: Reach, patch: number): Plan {
  return reach.header.patches[patch]!.grid === null ? twoSides(reach, patch) : rowsAndColumns(reach, patch);
}

/** The tip of the hand in the frame of the patch's link, in the first frame. */
function tipInLink(reach: Reach, patch: number): number[] {
  const pose = reach.patchPose.slice(7 * patch, 7 * patch + 7);
  const from = [0, 1, 2].map((axis) => reach.tip[axis]! - pose[axis]!) as Triple;
  // The inverse rotation.
  pose[6]! *= -1;
  return rotate(pose, 0, from);
}

function distance(a: number[], b: number[]): number {
  return Math.hypot(...a.map((value, axis) => value - b[axis]!));
}

function rowsAndColumns(reach: Reach, patch: number): Plan {
  const { grid, first_taxel: first, taxels } = reach.header.patches[patch]!;
  const { rows, columns } = grid!;
  const tip = tipInLink(reach, patch);
  const [start, end] = [triple(reach.taxelPosition, first), triple(reach.taxelPosition, first + taxels - 1)];
  const nearer = distance(start, tip) - distance(end, tip);
  const lastIsNearer = nearer > 0;
  const cells = Array.from({ length: taxels }, (_, index) => {
    const row = Math.floor(index / columns);
    const line = lastIsNearer ? rows - 1 - row : row;
    return { taxel: first + index, x: (index % columns) + 0.5, y: line + 0.5, size: 1 };
  });
  return { cells, width: columns, height: rows, upwards: Math.abs(nearer) > 0.1 * distance(start, end), twoSides: false };
}

/** A patch is square if its taxels lie at least so much apart across its longest direction, as a share of the squares along it. */
const SQUARE = 0.9;

function dot(a: number[], b: number[]): number {
  return a[0]! * b[0]! + a[1]! * b[1]! + a[2]! * b[2]!;
}

/** The direction in which points lie farthest apart, by power iteration, orthogonal to `others`. */
function longest(points: number[][], others: Triple[]): Triple {
  // Of points in a square the first direction is that of the start, of which a second one needs a part beside it.
  let axis: Triple = others.length === 0 ? [0.53, 0.61, 0.59] : [0.54, 0.6, 0.59];
  for (let round = 0; round < 60; round++) {
    const next: Triple = [0, 0, 0];
    for (const point of points) {
      const along = dot(point, axis);
      for (let index = 0; index < 3; index++) next[index]! += along * point[index]!;
    }
    for (const other of others) {
      const along = dot(next, other);
      for (let index = 0; index < 3; index++) next[index]! -= along * other[index]!;
    }
    const length = Math.hypot(...next) || 1;
    axis = next.map((value) => value / length) as Triple;
  }
  return axis;
}

/** Moves squares of this size on the same side just so far that none covers another. */
function moveApart(squares: { back: boolean; x: number; y: number }[], size: number): void {
  // Plain loops without new arrays: up to 200 rounds over all pairs are on the way to the first picture.
  for (let round = 0; round < 200; round++) {
    let moved = false;
    for (let first = 0; first < squares.length; first++) {
      const a = squares[first]!;
      for (let second = first + 1; second < squares.length; second++) {
        const b = squares[second]!;
        if (a.back !== b.back) continue;
        const dx = b.x - a.x;
        const dy = b.y - a.y;
        const overX = size - Math.abs(dx);
        const overY = size - Math.abs(dy);
        if (overX <= 1e-9 || overY <= 1e-9) continue;
        moved = true;
        const along = overX < overY ? "x" : "y";
        const step = (0.51 * Math.min(overX, overY) + 1e-9) * ((along === "x" ? dx : dy) < 0 ? -1 : 1);
        a[along] -= step;
        b[along] += step;
      }
    }
    if (!moved) return;
  }
}

function twoSides(reach: Reach, patch: number): Plan {
  const { first_taxel: first, taxels } = reach.header.patches[patch]!;
  const rows = (vectors: Float32Array) => Array.from({ length: taxels }, (_, index) => triple(vectors, first + index));
  const [places, normals] = [rows(reach.taxelPosition), rows(reach.taxelNormal)];
  const mean = [0, 1, 2].map((axis) => places.reduce((sum, place) => sum + place[axis]!, 0) / taxels);
  const centred = places.map((place) => place.map((value, axis) => value - mean[axis]!));
  let along = longest(centred, []);
  let across = longest(centred, [along]);
  // A square is longest in no direction. Its rows and columns lie as from its first taxel to the nearest one.
  const spread = (axis: Triple) => centred.reduce((sum, place) => sum + dot(place, axis) ** 2, 0);
  if (spread(across) > SQUARE * spread(along)) {
    const outwards = cross(along, across);
    const steps = centred.map((place) => cross(outwards, place.map((value, axis) => value - centred[0]![axis]!) as Triple));
    const [nearest] = steps.filter((step) => Math.hypot(...step) > 1e-6).sort((a, b) => Math.hypot(...a) - Math.hypot(...b));
    along = longest([nearest!], []);
    across = longest(centred, [along, outwards]);
  }
  const tip = tipInLink(reach, patch).map((value, axis) => value - mean[axis]!);
  // Up on the map is towards the tip.
  if (dot(tip, along) < 0) along = along.map((value) => -value) as Triple;
  const facing = cross(along, across);
  const flat = centred.map((place, index) => {
    const back = dot(normals[index]!, facing) < 0;
    return { index, back, x: dot(place, across) * (back ? -1 : 1), y: -dot(place, along) };
  });
  // As large as most can be without touching their neighbours.
  const gaps = flat.map((own) => Math.min(...flat.filter((other) => other !== own && other.back === own.back).map((other) => Math.max(Math.abs(own.x - other.x), Math.abs(own.y - other.y)))));
  // A taxel alone on its side is infinitely far from others there, and taxels in one place have no gap.
  const finite = gaps.filter((gap) => Number.isFinite(gap) && gap > 0).sort((a, b) => a - b);
  const size = 0.95 * (finite[Math.floor(finite.length / 2)] ?? 0.01);
  moveApart(flat, size);
  const width = Math.max(...flat.map(({ x }) => Math.abs(x))) * 2 + 1.6 * size;
  const top = Math.min(...flat.map(({ y }) => y)) - 0.8 * size;
  // Taxels that all face one way are seen from there alone.
  const twoSides = flat.some(({ back }) => back !== flat[0]!.back);
  const cells = flat.map(({ index, back, x, y }) => {
    return { taxel: first + index, x: x + width / 2 + (twoSides && back ? 1.15 * width : 0), y: y - top, size };
  });
  const height = Math.max(...cells.map(({ y }) => y)) + 0.8 * size;
  return { cells, width: (twoSides ? 2.15 : 1) * width, height, upwards: Math.abs(dot(tip, along)) > 0.1 * Math.hypot(...tip), twoSides };
}
