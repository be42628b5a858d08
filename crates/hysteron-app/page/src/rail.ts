// Rooms of the rail, in the order of their keys.
import type { Room } from './route';

export const RAIL: [Room, string][] = [
  ['records', 'Records'],
  ['identify', 'Identify'],
  ['compare', 'Compare'],
  ['validate', 'Validate'],
  ['follow', 'Follow'],
  ['home', 'Take it home'],
  ['try', 'Try'],
];
