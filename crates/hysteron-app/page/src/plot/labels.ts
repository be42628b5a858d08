// Words beside points, placed so that they cover neither each other nor a point.

export interface Point {
  left: number;
  top: number;
  text: string;
}

export interface Placed extends Point {
  /** The text ends at its place instead of beginning there. */
  end: boolean;
}

interface Box {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

const HEIGHT = 14;
const DISTANCE = 9;
/** Right and left of the point, then above and below on either side. */
const TRIALS = [0, -13, 13, -26, 26, -39, 39].flatMap((up) => [
  { up, end: false },
  { up, end: true },
]);

const overlap = (a: Box, b: Box): boolean =>
  a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;

/** Places the words of `points` within `area`; `width` measures a text. Lengths in pixels of the page. */
export function placed(points: Point[], area: Box, width: (text: string) => number): Placed[] {
  const taken: Box[] = points.map(({ left, top }) => ({
    left: left - 5,
    right: left + 5,
    top: top - 5,
    bottom: top + 5,
  }));
  return points.map((point) => {
    const length = width(point.text);
    const boxOf = ({ up, end }: (typeof TRIALS)[0]): Box => {
      const left = end ? point.left - DISTANCE - length : point.left + DISTANCE;
      return {
        left,
        right: left + length,
        top: point.top + up - HEIGHT / 2,
        bottom: point.top + up + HEIGHT / 2,
      };
    };
    const free = TRIALS.find((trial) => {
      const box = boxOf(trial);
      const inside = box.left >= area.left && box.right <= area.right;
      return (
        inside && box.top >= area.top && box.bottom <= area.bottom && !taken.some((t) => overlap(t, box))
      );
    });
    const trial = free ?? { up: 0, end: false };
    taken.push(boxOf(trial));
    return {
      text: point.text,
      end: trial.end,
      left: point.left + (trial.end ? -DISTANCE : DISTANCE),
      top: point.top + trial.up + 4,
    };
  });
}
