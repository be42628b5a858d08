// The page: top bar, rail, room, dock.
import 'uplot/dist/uPlot.min.css';
import './styles/base.css';
import './styles/shell.css';
import './styles/controls.css';
import './styles/words.css';
import './styles/records.css';
import './styles/plot.css';
import './styles/dock.css';
import './styles/forms.css';
import './styles/rooms.css';
import { render, type VNode } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { Dock, said } from './components/dock';
import { Rail, Top } from './components/shell';
import { Undo } from './components/undo';
import { listen } from './keys';
import { Compare } from './rooms/compare';
import { Follow } from './rooms/follow';
import { Missing } from './components/missing';
import { History } from './rooms/history';
import { Home } from './rooms/home';
import { Identify } from './rooms/identify';
import { Records } from './rooms/records';
import { Try } from './rooms/try';
import { Validate } from './rooms/validate';
import { route, type Room } from './route';
import { useSignal } from './signal';
import { follow } from './store';

const VIEWS: Record<Room, () => VNode> = {
  records: Records,
  identify: Identify,
  compare: Compare,
  validate: Validate,
  follow: Follow,
  home: Home,
  try: Try,
  history: History,
};

function App() {
  const { room } = useSignal(route);
  const View = VIEWS[room];
  const visited = useRef(room);
  useEffect(() => {
    if (visited.current === room) return;
    visited.current = room;
    scrollTo(0, 0);
    document.querySelector<HTMLElement>('h1')?.focus({ preventScroll: true });
  }, [room]);
  return (
    <div class="shell">
      <a class="skip" href="#main" onClick={skip}>
        To the room
      </a>
      <Top />
      <Rail />
      <main id="main" tabIndex={-1}>
        <Missing />
        <View key={room} />
      </main>
      <Dock />
      <Undo />
      <Said />
    </div>
  );
}

/** The hash holds the state, so that the link itself must not change it. */
function skip(event: Event): void {
  event.preventDefault();
  document.getElementById('main')?.focus();
}

function Said() {
  return (
    <div class="vh" role="status">
      {useSignal(said)}
    </div>
  );
}

const root = document.getElementById('app');
if (root) {
  root.replaceChildren();
  render(<App />, root);
}
follow();
listen();
