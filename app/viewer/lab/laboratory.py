"""The laboratory: a flock that runs, a picture of it, and panels to steer it, in a browser."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import viser

from agents.catalogue import MODELS, PLAYED
from agents.flock import Flock
from agents.motion.steered_motion import Pilot
from agents.observables.catalogue import default_charts
from agents.observables.of_agents import measurable
from agents.spec import CompleteSpec, Spec
from app.front.controls import set_value
from app.front.notices import Notices
from app.front.origin import AllowedHost, local_address
from app.front.page_front import Front
from app.front.server import admit_browsers, close_server, front_of, on_browser_message, open_server
from app.front.uploads import accept_uploads
from app.results_folder import RESULTS
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.fits.fit_worker import TracksFit
from app.viewer.lab.panels.downloads import Downloads, SceneFiles
from app.viewer.lab.panels.fit_panel import FitPanel
from app.viewer.lab.panels.flock_monitors import BELOW, BLOCKS, CrashLists, contents
from app.viewer.lab.panels.flock_view import FlockView
from app.viewer.lab.panels.inspector import Inspector
from app.viewer.lab.panels.laboratory_plots import LaboratoryPlots
from app.viewer.lab.panels.lesson_form import LessonForm
from app.viewer.lab.panels.lesson_panel import LessonPanel
from app.viewer.lab.panels.model_guide import Guide, TryRunner
from app.viewer.lab.panels.numbers_table import MoreNumbers, NumbersTable
from app.viewer.lab.panels.rule_source import RuleSource
from app.viewer.lab.panels.run_panel import RunPanel, TimeLinePanel
from app.viewer.lab.panels.runs_panel import RunsPanel
from app.viewer.lab.panels.setup import SetupPanel
from app.viewer.lab.panels.step_progress import LessonLead
from app.viewer.lab.panels.sweep_panel import SweepPanel
from app.viewer.lab.panels.tracks_panel import TracksPanel
from app.viewer.lab.panels.world_panel import WorldPanel
from app.viewer.lab.picture_exporter import PictureExporter
from app.viewer.lab.runs_file import ReadRuns, RunsFile
from app.viewer.lab.scene_requests import SCRIPTS, SceneRequests
from app.viewer.lab.steer_requests import SteerRequests
from app.viewer.lab.sweeps.laboratory_sweeps import SweepRequestHandler, Sweeps, refuse_sweeps
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.kept_runs import KeptRuns
from app.viewer.measuring.observable_curves import chart_title
from app.viewer.measuring.observable_format import observable_words
from app.viewer.panels.differences import DifferencesPanel
from app.viewer.panels.kinds import KindsPanel
from app.viewer.panels.monitors import Monitors
from app.viewer.panels.parameters import ParametersPanel
from app.viewer.panels.sending import ExportPermit
from app.viewer.panels.shell import add_hotkeys, dock, set_look
from app.viewer.run.allowance import Allowance
from app.viewer.run.edits import leader, usable_pose
from app.viewer.run.flock_run import describe_error
from app.viewer.run.frame_builder import FrameRequest, WatchPageRequest
from app.viewer.run.run_preset import drawing_defaults, lively_speed, preset_spec
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState
from app.viewer.run.stored_flock import LARGEST, InitialState
from app.viewer.run.stored_tracks import StoredTracks
from app.viewer.scene.drawing import Drawing, Rates
from app.viewer.scene.scene import Scene
from app.viewer.scene.shown.colouring import COLOURINGS
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Frame
from app.viewer.scene.shown.frame_interpolator import FrameInterpolator
from worlds.input_error import InputError

FROM_THE_START = ", from tick 0"
UNWATCHED = 600.0
"""Time after which a flock that nobody watches stands, s."""
"""Said of a scene that is made of a state or a recording: it has their run, not their tick."""


def rates_of(allowance: Allowance | None) -> Rates:
    """How often there is something new on the page, by what it may take."""
    if allowance is None:
        return Rates()
    return Rates(
        fastest=1.0 / allowance.pictures,
        panels=allowance.panels,
        unseen=allowance.unseen,
        bandwidth=allowance.bandwidth,
        share=allowance.share,
    )


class Laboratory:
    """Serves one flock to any number of browsers; all see the same run.

    `allow`: names by which browsers may reach it beside this machine's own. `server`: one that is
    open already, on this host. `opened`: a scene, a saved state, a recording or a flock in hand
    that it opens on, instead of a `spec`. `waits`: whether the flock stands until the first browser
    is there. `results`: the folder of its sweeps. `runs`: the file in which its runs are kept;
    None: they are kept as long as it is there. `allowance`: what it may take and do; None:
    everything. `played`: the kind of agents of a scene that who sits before it plays; empty: all.
    `pilots` steer agents, beside policies and people. Raises InputError if the port is busy.
    """

    def __init__(
        self,
        spec: CompleteSpec | None = None,
        host: str = "127.0.0.1",
        port: int = 8080,
        speed: float | None = None,
        running: bool = True,
        allow: tuple[AllowedHost, ...] = (),
        beside: Spec | None = None,
        threads: int = 1,
        server: viser.ViserServer | None = None,
        opened: SavedScene | InitialState | None = None,
        waits: bool = False,
        results: Path = RESULTS,
        runs: RunsFile | None = None,
        allowance: Allowance | None = None,
        played: str = "",
        pilots: Sequence[Pilot] = (),
    ):
        self.server = server or open_server(host, port, Front(SCRIPTS, allow))
        self.host = host
        self.allowance = allowance
        self.making = ExportPermit(allowance)
        scene = opened if isinstance(opened, SavedScene) else None
        self.shown_scene = scene
        if opened is not None:
            spec, speed = opened.spec, speed or opened.speed
            beside = getattr(opened, "beside", None)
        spec = spec or preset_spec()
        self.simulation = Simulation(
            spec,
            beside,
            speed or lively_speed(spec),
            running and not waits,
            build=partial(Flock, threads=threads),
            stored=None if isinstance(opened, SavedScene) else opened,
            allowance=allowance,
            pilots=pilots,
        )
        self.simulation.play(played, spec)
        self.notices = Notices(self.server, self.simulation.notices)
        with self.server.atomic():
            self.scene = Scene(self.server)
        self.selected: int | None = None
        self.selected_beside = False
        self.selected_identity: tuple[int, int] | None = None
        """In which run it is whom, where agents come and go."""
        self.wanted = FrameRequest()
        self.watched: frozenset[str] = frozenset()
        self.elsewhere = WatchPageRequest()
        """What the pages of those who only watch want to know."""
        self.contents: dict[str, str] = {}
        """What the monitors show, by block."""
        self.between = FrameInterpolator()
        self.pointing: tuple[float, str] | None = None
        """After which run, and to what, all cameras are to be pointed; after run infinity: what is
        to come still waits to be set up."""
        self.choosing = threading.Lock()
        """Held while another scene becomes the one that is shown, or none does: the thread that
        draws drops one that neither runs nor is to come."""
        self.charted: tuple[int, StoredTracks] | None = None
        """After which run charts are to show what tells most of tracks, and of which."""
        self.waits = running and waits
        self.watched_at = time.monotonic()
        """When it was watched last, s of the monotonic clock."""
        self.rested = False
        """Whether it stands since nobody watched, and nobody has been told."""
        self.runs_file = runs
        self.sweeps: Sweeps | None = None
        self.fit: TracksFit | None = None
        self.fit_panel: FitPanel | None = None
        self.sweep: SweepPanel | None = None
        if allowance is None or allowance.sweeps:
            self.sweeps = Sweeps(results, lambda: self.browsers() > 0)
            self.fit = TracksFit(results, self.simulation.news.set)
        self.furnish()
        self.requests = SceneRequests(front_of(self.server), self)
        self.runs.listen(self.requests)
        SteerRequests(self.requests, self.simulation)
        if self.sweeps is not None and self.sweep is not None:
            SweepRequestHandler(self.requests, self.sweeps, self.sweep)
        else:
            refuse_sweeps(self.requests)
        self.take_uploads()
        if scene is not None:
            self.look_at(scene)
            self.pointing = 0, scene.camera  # its run is the first
        elif isinstance(opened, StoredTracks):
            self.charted = -1, opened
        self.drawing = Drawing(
            self.scene,
            self.latest,
            self.browsers,
            self.want,
            self.refresh,
            self.simulation.news,
            lambda: self.between.moves,
            rates_of(allowance),
            self.changes,
        )
        on_browser_message(self.server, self.simulation.news.set)
        self.taking = PictureExporter(self, self.making)
        self.listen()
        self.drawing.start()
        admit_browsers(self.server)  # last: browsers find all of the above

    @property
    def port(self) -> int:
        """The port that it serves on."""
        return self.server.get_port()

    @property
    def address(self) -> str:
        """Where a browser on this machine finds it."""
        return local_address(self.host, self.port)

    def close(self) -> None:
        """Stop drawing, running and serving; a sweep that runs goes on."""
        going = "" if self.sweeps is None else self.sweeps.close()
        if going:
            line = f"the sweep {going} goes on; `flockscope sweep stop {going}` ends it"
            print(line, file=sys.stderr)
        if self.fit is not None:
            self.fit.close()
        self.drawing.close()
        self.simulation.close()
        self.plots.runs.close()
        close_server(self.server)

    def furnish(self) -> None:
        """Build the panels."""
        gui = self.server.gui
        set_look(gui, "flockscope")
        state = self.simulation.state
        run_place = gui.add_folder(None)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Rule"):
            self.rule_source = RuleSource(gui)
            self.parameters = ParametersPanel(gui, self.simulation)
            self.differences = DifferencesPanel(gui, self.simulation, self.parameters)
            self.kinds = KindsPanel(gui, self.simulation, self.parameters)
            marks = gui.add_html("")
            self.rule_source.add(gui)
        with tabs.add_tab("Setup"):
            self.setup = SetupPanel(gui, state)
        with tabs.add_tab("World"):
            self.world = WorldPanel(self.server, self.simulation, self.scene.handles.show)
        tell = self.simulation.notices.put
        with tabs.add_tab("View"):
            self.view = FlockView(gui, drawing_defaults(state.spec), self.point)
        if self.sweeps is not None:
            with tabs.add_tab("Sweep"):
                self.sweep = SweepPanel(gui, marks, self.sweeps, self.simulation, tell)
        with tabs.add_tab("Save"):
            Downloads(gui, self.simulation)
            self.saving = SceneFiles(
                gui,
                self.now,
                self.open,
                tell,
                lambda name, content: self.tracks.read(name, content),
                self.allowance,
            )
            self.lesson_form = LessonForm(gui, self.now, self.take_steps, tell)
        with tabs.add_tab("Tracks"):
            self.tracks = TracksPanel(gui, self.simulation, self.open_tracks, tell, self.allowance)
        if self.fit is not None:
            with tabs.add_tab("Fit"):
                self.fit_panel = FitPanel(gui, self.fit, self.tracks, self.shown_tick, tell)
        with run_place:
            self.run = RunPanel(gui, self.simulation, self.setup)
            self.lesson = LessonPanel(
                gui, self.simulation, self.parameters, self.setup.follow, self.plot_first
            )
            self.time_line = TimeLinePanel(gui, self.simulation)
        guide = gui.add_button("Guide", icon=viser.Icon.BOOK, color="gray")
        guide.on_click(self.guide_clicked)
        left = gui.add_panel()
        with left.add_tab("Monitors", viser.Icon.CHART_LINE) as numbers:
            self.monitors = Monitors(gui, BLOCKS, "tick")
            self.sight_lines = self.monitors.sight_lines(self.server, numbers)
            self.plots = LaboratoryPlots(self.server, self.kept_runs(), self.making)
            self.monitors.add(gui, BELOW)
            self.crashes = CrashLists(gui, self.show_crash)
            self.more = MoreNumbers(gui)
            self.numbers = NumbersTable(self.server, self.more, self.plots.sender)
        with left.add_tab("Runs", viser.Icon.NOTEBOOK):
            self.runs = RunsPanel(self.server, self.plots, self.sweeps, tell, self.where_kept())
        dock(gui, left)
        self.guide = Guide(self.server, TryRunner(self.simulation, self.parameters, self.setup))
        self.inspector = Inspector(gui, lambda: self.select(None))

    def kept_runs(self) -> KeptRuns:
        """Its runs, with those that are in its file."""
        file = self.runs_file
        if file is None:
            return KeptRuns()
        file.tell = self.simulation.notices.put
        if file.found.skipped:
            file.tell(file.found.told(str(file.path)))
        return KeptRuns(file.found.runs, file)

    def where_kept(self) -> str:
        """Where its runs are kept, in a sentence."""
        if self.runs_file is None:
            return "Runs are kept until the laboratory ends: take them along as JSONL."
        return f"Runs are kept in {self.runs_file.path}."

    def take_uploads(self) -> None:
        """Take files through the buttons for them, as large as is allowed."""
        if self.allowance is None:
            accept_uploads(self.server, LARGEST)
        else:
            most = min(LARGEST, self.allowance.upload)
            accept_uploads(self.server, most, bound="a class takes {} at most")

    def listen(self) -> None:
        """Connect clicks, drags and keys, and the first browser."""
        self.server.on_client_connect(self.welcome)
        self.scene.on_clicked(self.clicked)
        self.scene.handles.on_dragged(self.world.handle_drag)
        self.scene.on_leader_dragged(self.steer)
        self.view.steer.on_update(self.steering_switched)
        add_hotkeys(
            self.server.gui,
            {
                "space": lambda _: self.simulation.toggle(),
                "T": lambda _: self.simulation.step(),
                "R": lambda _: self.simulation.reset(),
                "N": lambda _: self.run.set_up(),
                "pageup": lambda _: self.run.change_speed(1),
                "pagedown": lambda _: self.run.change_speed(-1),
                "1": lambda client: self.point(client, "top-down"),
                "2": lambda client: self.point(client, "perspective"),
                "3": lambda client: self.point(client, "side"),
                "F": lambda client: self.point(client, "follow"),
                "C": lambda _: self.view.next_colour(),
                "L": lambda _: self.switch_links(),
                "H": self.show_guide,
                "U": lambda _: self.parameters.undo(),
                "Z": lambda _: self.world.undo(),
                "Y": lambda _: self.world.redo(),
                "delete": lambda _: self.world.delete(),
                "escape": lambda _: self.world.drop_tool(),
            },
        )

    # What browsers ask for.

    async def welcome(self, _client: viser.ClientHandle) -> None:
        """Somebody watches, here or on the page of those who only watch: see `begin`."""
        self.begin()
        if self.rested:
            self.rested = False
            self.simulation.notices.put("Paused: no browser had watched for ten minutes. Press Go.")
        self.drawing.show_to_newcomer()

    def begin(self) -> None:
        """Let a flock begin that waited for somebody to watch."""
        if self.waits:
            self.waits = False
            self.simulation.go()

    def open(self, opened: SavedScene | InitialState | ReadRuns) -> None:
        """Set up a scene, a state or a recording in all browsers, and let it run; runs of a file
        become rows.

        Raises InputError for what an allowance, or the kind that is played, does not allow.
        """
        if isinstance(opened, ReadRuns):
            self.plots.runs.take(opened.runs)
            self.simulation.notices.put(opened.told("the file"))
            return
        if self.simulation.played is not None:
            if not isinstance(opened, SavedScene):
                raise self.simulation.played.refuse("the run")
            self.simulation.played.demand_run(opened.spec, opened.beside)
        if isinstance(opened, StoredTracks):
            self.open_tracks(opened, True)
            return
        if self.allowance is not None:
            stored = None if isinstance(opened, SavedScene) else opened
            self.allowance.demand(opened.spec, getattr(opened, "beside", None), stored)
        self.waits = False
        self.parameters.expect_scene()
        self.select(None)
        self.run.pace(opened.speed or lively_speed(opened.spec))
        if not isinstance(opened, SavedScene):
            self.shown_scene = None
            self.setup.follow(opened.spec, None)
            self.scene.open_on("")
            expected = self.expect_run("")
            self.point_after(self.simulation.open(opened), expected)
        else:
            with self.choosing:
                expected = self.expect_run(opened.camera)
                self.shown_scene = opened
            self.setup.follow(opened.spec, opened.beside)
            self.look_at(opened)
            self.point_after(self.simulation.setup(opened.spec, opened.beside), expected)
        self.simulation.go()

    def expect_run(self, camera: str) -> tuple[float, str]:
        """Have cameras pointed once a run is there that is yet to be asked for; what is expected,
        for `point_after`."""
        self.pointing = expected = (math.inf, camera)
        return expected

    def point_after(self, asked: Future, expected: tuple[float, str]) -> None:
        """Once a set-up is next, point cameras at the run after the one that is there then.

        Until then another one may be built, which was asked for before.
        """

        def note(done: Future) -> None:
            if self.pointing is not expected:
                return  # something else was opened since
            refused = done.exception() is not None
            self.pointing = None if refused else (self.simulation.state.run, expected[1])

        asked.add_done_callback(note)

    def open_played(self, scene: SavedScene, played: str) -> None:
        """Begin with a scene in which who sits before it plays a kind of agents; empty: all of
        them. Raises InputError."""
        self.simulation.play(played, scene.spec)
        self.open(scene)

    def open_tracks(self, stored: StoredTracks, is_new: bool) -> None:
        """Play tracks in all browsers, or others of them, with a model or without. Raises
        InputError."""
        if self.simulation.played is not None:
            raise self.simulation.played.refuse("the run")
        if self.allowance is not None:
            self.allowance.demand(stored.spec, stored.beside, stored)
        self.waits = False
        self.parameters.expect_scene()
        self.select(None)
        self.shown_scene = None
        self.charted = self.simulation.state.run, stored
        expected = None
        if is_new:
            self.run.pace(stored.speed, is_exact=True)
            self.scene.open_on("")
            expected = self.expect_run("")
        elif stored.start is None or not stored.start.is_over:
            expected = self.expect_run("")
        asked = self.simulation.open(stored)
        if expected is not None:
            self.point_after(asked, expected)
        self.simulation.go()

    def shown_tick(self) -> int:
        """The tick of the frame that is there; 0 before the first one."""
        frame = self.simulation.frame
        return 0 if frame is None else frame.tick

    def chart_tracks(self, stored: StoredTracks, readings: FlockReadings) -> None:
        """Have the charts show what tells most of tracks, or of a model that is compared."""
        model = stored.recording.model
        charts = default_charts(model, readings.offered)
        self.plots.asked = model, tuple(map(chart_title, charts))

    def take_rule(self, path: Path) -> None:
        """Have the flock go on under what the file of a rule says now; what is wrong is told."""
        answer = self.simulation.take_rule(path)

        def told(done: Future) -> None:
            if (fault := done.exception()) is not None:
                self.rule_source.refuse(describe_error(fault))
            else:
                self.rule_source.take(path)

        answer.add_done_callback(told)

    def look_at(self, scene: SavedScene) -> None:
        """Have the view and the plots as a scene has them."""
        self.view.set_defaults(drawing_defaults(scene.spec))
        self.view.take(scene.look)
        self.plots.asked = MODELS[scene.spec.model], scene.plots
        self.scene.open_on(scene.camera)

    def take_steps(self, scene: SavedScene) -> None:
        """Show the lesson of a scene that is what runs, with other steps."""
        self.shown_scene = scene
        self.simulation.news.set()

    def lead(self, lead: LessonLead) -> None:
        """Show the step of a class's lesson in all browsers, or let them go their own way."""
        self.lesson.follow_lead(lead)

    def plot_first(self, observable: str) -> None:
        """Have the first chart show an observable, once the flock has it."""
        model = MODELS[
            self.simulation.state.spec.model
            if self.shown_scene is None
            else self.shown_scene.spec.model
        ]
        pending = self.plots.asked  # of a lesson that opens: it is shown with its first step
        others = pending[1] if pending is not None and pending[0] is model else ()
        names = map(observable_words, (observable, *others))
        self.plots.asked = model, tuple(dict.fromkeys(names))

    def now(self, title: str = "") -> SavedScene:
        """The run, with the parameters as they are now, and the view, as a scene. Raises InputError
        for tracks."""
        state, before = self.simulation.state, self.told_scene()
        if state.spec.model in PLAYED:
            raise InputError(
                "a scene holds a model and no tracks: open the file of tracks again instead"
            )
        if before is not None and self.pointing is not None and state.run <= self.pointing[0]:
            return replace(before, title=title or before.title)  # it is about to be set up
        spec, beside = state.current_specs()
        scene = SavedScene(
            title or MODELS[spec.model].title + (FROM_THE_START if state.stored else ""),
            spec,
            beside,
            speed=state.speed,
            plots=self.plots.chosen,
            look=self.view.changed_values(),
        )
        if before is None:
            return scene
        return replace(
            scene,
            title=title or before.title,
            watch=before.watch,
            tries=before.tries,
            camera=before.camera,
            steps=before.steps,
        )

    def told_scene(self) -> SavedScene | None:
        """The scene that was opened, as long as it is what runs."""
        scene, state = self.shown_scene, self.simulation.state
        coming = self.pointing is not None and state.run <= self.pointing[0]
        if scene is None or state.busy or coming:
            return scene
        agents = {scene.spec.agents, *(step.set.get("agents") for step in scene.steps)}
        same = scene.spec.world == state.spec.world and state.spec.agents in agents
        if same and (scene.spec.model, scene.beside and scene.beside.model) == state.models:
            return scene
        with self.choosing:  # else a scene that is opened just now would be dropped with this one
            if self.pointing is None and self.shown_scene is scene:
                self.shown_scene = None
                self.scene.open_on("")
        return None

    async def guide_clicked(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.show_guide(event.client)

    def show_guide(self, client: viser.ClientHandle) -> None:
        """Open the guide to the running model in one browser."""
        self.guide.show(client, self.simulation.state.spec.model)

    async def steering_switched(self, _event: viser.GuiEvent) -> None:
        self.scene.show_leader_gizmo(self.view.steer.value and self.simulation.played is None)

    def clicked(
        self, row: int | None, origin: np.ndarray, direction: np.ndarray, beside: bool = False
    ) -> None:
        """A click into the picture: for the tool of the World tab, or on an agent or obstacle.

        `beside` says that it is in the second flock's room; the ray is in that one's world.
        """
        if self.world.handle_click(origin, direction):
            return
        self.select(row, beside)
        if row is None:
            self.world.select_at(origin, direction)
        else:
            self.world.select(0)

    def select(self, row: int | None, beside: bool = False) -> None:
        """Inspect an agent, of the flock beside if so; None for none."""
        self.selected, self.selected_beside = row, beside and row is not None
        self.selected_identity = None

    def keep_selected(self, frame: Frame) -> None:
        """Stay with the selected agent where others come and go, until it is gone itself."""
        if self.selected is None or not frame.has_turnover:
            self.selected_identity = None
        elif self.selected_identity is None or self.selected_identity[0] != frame.run:
            if self.selected < len(frame.ids):
                self.selected_identity = frame.run, int(frame.ids[self.selected])
        else:
            rows = np.flatnonzero(frame.ids == self.selected_identity[1])
            if len(rows):
                self.selected = int(rows[0])
            else:
                self.select(None)

    def switch_links(self) -> None:
        """Show links, or hide them."""
        links = self.view.form["links"]
        set_value(links, not links.value)

    def point(self, client: viser.ClientHandle, camera: str) -> None:
        """Point one browser's camera."""
        if camera == "follow" and self.selected is not None:
            self.scene.follow(client, self.selected, int(self.selected_beside))
        else:
            self.scene.camera(client, camera)

    def steer(self, position: np.ndarray, heading: np.ndarray) -> None:
        """Put the information agent where it was dragged, within the world."""
        frame = self.simulation.frame
        row = leader(frame)
        if frame is None or row is None:
            return
        pose = usable_pose(frame, position, heading)
        if pose is not None:
            self.simulation.place(row, *pose)

    def show_crash(self, client: viser.ClientHandle, row: int, beside: bool) -> None:
        """Inspect an agent that has crashed, and point one browser's camera at it."""
        self.select(row, beside)
        self.scene.follow(client, row, int(beside))

    # What the drawing thread asks for.

    def latest(self) -> tuple[Frame | None, DrawingStyle]:
        """The newest frame, or one on the way to it, and how to draw it."""
        state = self.simulation.state
        frame = self.between.frame(
            self.simulation.frame, state.running, state.speed, time.monotonic()
        )
        return frame, self.view.drawing_style()

    def changes(self) -> object:
        """What the panels show at once when it is another."""
        state = self.simulation.state
        return state.run, state.running, state.busy, state.speed, state.error

    def want(self) -> None:
        """Tell browsers what the simulation has to say, and the simulation what is wanted."""
        is_watched = self.browsers() + self.elsewhere.browsers > 0
        if is_watched:
            self.watched_at = time.monotonic()
        self.simulation.set_watched(is_watched)
        self.simulation.hands.let_go_of_silent()
        self.notices.tell()
        self.world.refresh()
        look = self.view.drawing_style()
        wanted = FrameRequest(
            layers=COLOURINGS[look.colour].labels == "layer",
            groups=COLOURINGS[look.colour].labels == "group",
            measured=look.measured,
            links=look.links,
            points=look.points,
            row=self.selected,
            identity=None if self.selected_identity is None else self.selected_identity[1],
            beside=self.selected_beside,
            others=self.elsewhere.rows,
            others_beside=self.elsewhere.rows_beside,
        )
        if wanted != self.wanted:
            self.wanted = wanted
            self.simulation.set_request(wanted)

    def refresh(self) -> None:
        """Bring the panels up to date."""
        state, readings = self.simulation.state, self.simulation.readings
        scene = self.told_scene()
        by_hand = self.simulation.hands.steered
        played = self.simulation.played
        if played is not None and self.view.steer.value:  # from before: it has no switch any more
            set_value(self.view.steer, False)
            self.scene.show_leader_gizmo(False)
        self.run.refresh(state, scene, by_hand)
        self.lesson.follow(scene, state)
        self.lesson_form.refresh(scene, state.spec.model)
        self.time_line.refresh(state, self.simulation.frame)
        self.setup.catch_up(state.spec)
        self.setup.refresh(state, played is not None)
        self.tracks.refresh(state)
        if self.fit_panel is not None:
            self.fit_panel.refresh(state)
        self.parameters.refresh(state)
        self.differences.refresh(state)
        self.kinds.refresh(state, self.simulation.frame)
        self.rule_source.refresh(state.spec.model)
        if self.sweep is not None:
            sliders = self.parameters.controls | self.kinds.axes
            self.sweep.refresh(state, self.plots.offered, sliders)
        if self.drawing.drawn is None or readings is None:
            return
        frame, look = self.drawing.drawn
        self.point_all(frame)
        self.measure(state, frame, readings)
        if self.pointing is None:  # else another flock, whose look is there already, is coming
            self.view.set_defaults(drawing_defaults(state.spec))
            numbers = measurable(MODELS[state.spec.model].columns, frame.own)
            self.view.fit(frame, numbers, played is None)
        self.monitors.colours(look, frame)
        for client in self.server.get_clients().values():
            self.sight_lines.show(client, self.scene.in_sight(client))
        if self.selected_beside and frame.beside is None:
            self.select(None)
        looked_at = frame.beside if self.selected_beside and frame.beside else frame
        self.keep_selected(looked_at)
        drawn_at = self.scene.display_place(self.selected, int(self.selected_beside))
        by_hand = frozenset() if self.selected_beside else by_hand
        kind = "" if played is None else played.name
        self.inspector.refresh(looked_at, self.selected, drawn_at, by_hand, kind)
        if self.selected is not None and looked_at.inspected is None:
            self.simulation.look_again()

    def point_all(self, frame: Frame) -> None:
        """Point all cameras at a scene once it is there."""
        if self.pointing is None or frame.run <= self.pointing[0]:
            return
        (_, camera), self.pointing = self.pointing, None
        usual = "top-down" if frame.dim == 2 else "perspective"
        for client in self.server.get_clients().values():
            self.scene.camera(client, camera or usual)

    def measure(self, state: SimulationState, frame: Frame, readings: FlockReadings) -> None:
        """Show what has been measured, and say what is to be."""
        if self.charted is not None and frame.run > self.charted[0]:
            (_, stored), self.charted = self.charted, None
            self.chart_tracks(stored, readings)
        beside = None if frame.beside is None else self.simulation.readings_beside
        self.plots.refresh(readings, frame, beside, is_coming=self.pointing is not None)
        self.runs.refresh(self.plots.runs.going)
        self.more.offer(self.plots.offered)
        last = self.plots.last
        self.contents = contents(state, frame, readings, self.browsers(), beside, self.more, last)
        self.monitors.show(self.contents)
        self.crashes.refresh(readings, beside)
        self.numbers.refresh((readings,) if beside is None else (readings, beside), last)
        watched = self.plots.names | self.more.names | self.elsewhere.names
        if watched != self.watched:
            self.watched = watched
            self.simulation.watch(watched)

    def rest(self) -> bool:
        """Pause a flock that nobody has watched for long; whether it was paused now."""
        left = time.monotonic() - self.watched_at > UNWATCHED
        if left and self.simulation.state.running:
            self.simulation.pause()
            self.watched_at, self.rested = time.monotonic(), True
            return True
        return False

    def browsers(self) -> int:
        """Number of browsers that watch."""
        return len(self.server.get_clients())
