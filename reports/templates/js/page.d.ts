// What the page carries beside its tables, as reports/embedding.py writes it.

type Table = { columns: string[]; length: number; values: Record<string, any>; rows?: any[] };
type PackedRun = { frames: string; momentum?: string; vertices?: string };
type PackedFilm = { t: number[]; truth: string; limit: number[]; runs: Record<string, PackedRun> };
type PageData = {
  ours: string;
  byHand: string;
  places: Record<string, number>;
  files: string[];
  tables: Partial<Record<keyof Tables, Table>>;
  films: Record<string, PackedFilm>;
};

type Vector = number[];
type Quaternion = Iterable<number>; // w, x, y, z

// What a table of the page shows of a row, and how it sorts by it.
type ShownColumn<Row> = {
  key: string;
  label: string;
  unit?: string;
  words?: boolean;
  show?: (row: Row) => any;
  sort?: (row: Row) => any;
};
type ShownTable<Row> = {
  id: string;
  caption: string;
  columns: ShownColumn<NoInfer<Row>>[];
  list: Row[];
  key: (row: NoInfer<Row>) => string;
  file?: string;
};

type ChartPoint = { x: number; y: number; plain: boolean; lines: string[]; low?: number; high?: number | null };
type ChartSeries = { name: string; points: ChartPoint[] };
type Axis = { label: string; log?: boolean; show?: (value: number) => string; ticks?: number[] };

// One contestant on film: its deviation from the truth, frame by frame.
type FilmRun = {
  frames: Float32Array[]; // x - x_true (3), q q_true^-1 (4), error, drifts of energy and of angular momentum
  momentum: Float32Array[] | null; // in body axes
  vertices: Float32Array[] | null; // of a body that is no longer rigid
};
type Edge = { ends: number[]; faces: number[] };
type Film = {
  scene: string;
  t: number[];
  end: number;
  body: Tables["bodies.csv"];
  points: Vector[];
  size: number;
  faces: number[][];
  edges: Edge[];
  loads: Tables["loads.csv"][];
  impulseFrames: Set<number>;
  truth: Float32Array[]; // x (3), q (4), v (3), w (3) in world axes, angular momentum (3) in body axes
  limit: number[];
  runs: Map<string, FilmRun>;
};
