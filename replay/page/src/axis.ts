// The time axis that timeline, strips and plots share: where a time lies between the left and the right margin.

/** Left margin, CSS pixels: the labels of the vertical axes. */
export const LEFT = 74;
/** Right margin, CSS pixels. */
export const RIGHT = 10;

export class TimeAxis {
  constructor(readonly width: number, readonly duration: number) {}

  get span(): number {
    return Math.max(this.width - LEFT - RIGHT, 1);
  }

  x(time: number): number {
    return LEFT + (time / (this.duration || 1)) * this.span;
  }

  time(x: number): number {
    return (Math.min(Math.max(x - LEFT, 0), this.span) / this.span) * this.duration;
  }
}
