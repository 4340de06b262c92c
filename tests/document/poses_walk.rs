//! Random walks over everything that decides about parts or moves them: what was decided comes back to the byte by undo, redo, saves
//! and crashes, where parts stand comes back with it, and where they rest depends on what was decided alone.
//!
//! Without the viewing force nothing is measured in pictures, so that these walks need no GPU. `BURIN_WALKS` sets how many (4).

use super::maker::{run, state, undone};
use crate::common::one::One;
use burin::document::Document;
use burin::math::{DVec3, Pose};
use burin::volume::{BRICK_VOXELS, Brick, BrickIndex};
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::PathBuf;

type Decided = (Vec<Vec<u8>>, String);

/// A document and what is to be expected of it.
struct Walk {
    rng: ChaCha8Rng,
    document: Document,
    project: PathBuf,
    /// What was decided before each step that undo knows, and after each that redo knows.
    undo: Vec<Decided>,
    redo: Vec<Decided>,
    /// What was decided when the open group began, and whether anything was since.
    group: Option<(Decided, bool)>,
    /// Where parts stood under explosions that were left, by what forces know of them.
    left: HashMap<String, Vec<Pose>>,
    /// Where they rest, by the same.
    rests: HashMap<String, Vec<Pose>>,
    trace: Vec<String>,
}

impl Walk {
    fn new(seed: u64, dir: &std::path::Path) -> Self {
        let mut state = state();
        // Selected, as a ball about the middle of one brick would be: anything that parts can leave.
        let texels: Vec<u8> = (0..BRICK_VOXELS).map(|i| if i % 3 == 0 { 255 } else { 0 }).collect();
        state.one_mut().selection.swap(vec![(BrickIndex([0, 0, 0]), Some(Brick::from_texels(texels, 1)))]).unwrap();
        let mut document = Document::new();
        document.adopt(state);
        let forces = json!({ "viewing": false, "measured_gain": false });
        let mut all = json!(document.state().unwrap().scene.explosion.forces);
        all.as_object_mut().unwrap().extend(forces.as_object().unwrap().clone());
        let project = dir.join(format!("walk-{seed}.burin"));
        let mut walk = Self {
            rng: ChaCha8Rng::seed_from_u64(seed),
            document,
            project: project.clone(),
            undo: Vec::new(),
            redo: Vec::new(),
            group: None,
            left: HashMap::new(),
            rests: HashMap::new(),
            trace: Vec::new(),
        };
        run(&mut walk.document, &json!({"explosion":{"forces":{"forces":all}}}).to_string()).unwrap();
        run(&mut walk.document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
        walk.reopen(false);
        walk
    }

    fn say(&mut self, command: &Value) -> Value {
        self.trace.push(command.to_string());
        run(&mut self.document, &command.to_string()).unwrap_or_else(|e| panic!("{e} after {:#?}", self.trace))
    }

    fn poses(&self) -> Vec<Pose> {
        self.document.poses().in_order(&self.document.state().unwrap().scene.explosion.parts)
    }

    /// What forces know of the explosion.
    fn pushed(&self) -> String {
        let mut explosion = json!(self.document.state().unwrap().scene.explosion);
        explosion["next_id"].take();
        for part in explosion["parts"].as_array_mut().unwrap() {
            part["name"].take();
            part["colour"].take();
        }
        explosion.to_string()
    }

    fn assert_same<T: PartialEq>(&self, found: &T, expected: &T, what: &str) {
        assert!(found == expected, "{what} after {:#?}", self.trace);
    }

    /// A command that decides something, and what that makes of the model.
    fn decide(&mut self, command: &Value) {
        let (before, pushed, stood) = (undone(&self.document), self.pushed(), self.poses());
        self.say(command);
        if undone(&self.document).1 == before.1 {
            return;
        }
        // Of a group undo brings back its beginning.
        let first = !matches!(self.group, Some((_, true)));
        match &mut self.group {
            Some((_, changed)) => *changed = true,
            None => {
                self.undo.push(before);
                self.redo.clear();
            }
        }
        if first {
            self.left.insert(pushed, stood);
        }
    }

    fn end_group(&mut self) {
        if let Some((begun, _)) = self.group.take()
            && begun.1 != undone(&self.document).1
        {
            self.undo.push(begun);
            self.redo.clear();
        }
    }

    fn travel(&mut self, verb: &str) {
        self.end_group();
        let steps = self.rng.random_range(1..4);
        let (pushed, stood) = (self.pushed(), self.poses());
        let mut expected = undone(&self.document);
        let mut any = false;
        for _ in 0..steps {
            let (from, to) =
                if verb == "undo" { (&mut self.undo, &mut self.redo) } else { (&mut self.redo, &mut self.undo) };
            let Some(next) = from.pop() else { break };
            to.push(std::mem::replace(&mut expected, next));
            any = true;
        }
        self.say(&json!({"history":{verb:{"steps":steps}}}));
        let found = undone(&self.document);
        self.assert_same(&found, &expected, verb);
        if any {
            self.left.insert(pushed, stood);
            if let Some(stood) = self.left.get(&self.pushed()) {
                self.assert_same(&self.poses(), stood, "poses");
            }
        }
    }

    fn settle(&mut self) {
        self.say(&json!({"explosion":{"settle":{}}}));
        let (pushed, rest) = (self.pushed(), self.poses());
        let known = self.rests.entry(pushed).or_insert_with(|| rest.clone()).clone();
        self.assert_same(&rest, &known, "the rest");
        assert!(!self.document.must_move(), "{:#?}", self.trace);
    }

    /// Opens the project anew: after a crash, or after the document was closed in order.
    fn reopen(&mut self, in_order: bool) {
        let document = std::mem::take(&mut self.document);
        if in_order {
            document.discard_unsaved().unwrap()
        } else {
            drop(document)
        }
        let answer = self.say(&json!({"project":{"open":{"path":self.project}}}));
        assert_eq!(answer["warnings"], json!([]));
        (self.undo, self.redo, self.group) = (Vec::new(), Vec::new(), None);
        self.left.clear();
    }

    fn crash(&mut self) {
        let told = (undone(&self.document), self.poses());
        self.reopen(false);
        let found = (undone(&self.document), self.poses());
        self.assert_same(&found, &told, "crash");
    }

    /// Without what cost a step, and the journal.
    fn move_parts(&mut self) {
        let known = |walk: &Self| {
            let journals = std::fs::read_dir(&walk.project).unwrap().map(|e| e.unwrap().path());
            let mut journals: Vec<PathBuf> =
                journals.filter(|p| p.extension().is_none() && p.to_string_lossy().contains("journal-")).collect();
            journals.sort();
            let bytes: Vec<Vec<u8>> = journals.iter().map(|p| std::fs::read(p).unwrap()).collect();
            let names = |d: &Document| d.history().undo_names().map(str::to_owned).collect::<Vec<_>>();
            (bytes, undone(&walk.document), names(&walk.document), walk.document.is_unsaved())
        };
        let before = known(self);
        if self.rng.random_range(0..3) == 0 {
            self.settle();
        } else {
            let steps = self.rng.random_range(1..60);
            self.say(&json!({"explosion":{"step":{"steps":steps}}}));
        }
        let after = known(self);
        self.assert_same(&after, &before, "a motion");
    }

    fn go(&mut self, commands: usize) {
        for _ in 0..commands {
            let parts = &self.document.state().unwrap().scene.explosion.parts;
            let id = parts.choose(&mut self.rng).unwrap().id.0;
            let many = parts.len() > 6;
            let mut unit = || self.rng.random_range(-1.0..1.0);
            let normal = [unit(), unit(), unit()];
            let shift = [unit() * 60.0, unit() * 60.0, unit() * 60.0];
            let turn = DVec3::new(unit(), unit(), unit()).normalize() * 0.6;
            match self.rng.random_range(0..22) {
                0..=2 => {
                    let value = [0.0, 0.3, 0.5, 1.0].choose(&mut self.rng).unwrap();
                    self.decide(&json!({"explosion":{"degree":{"value":value}}}));
                }
                3..=4 if !many => {
                    let point = shift.map(|v| v / 4.0);
                    self.decide(&json!({"part":{"split":{"by":{"plane":{"point":point,"normal":normal,"part":id}}}}}));
                }
                5 => self.decide(&json!({"part":{"reset":{}}})),
                6 => self.decide(&json!({"part":{"set":{"id":id,"name":format!("n{}", shift[0])}}})),
                7 => self.decide(&json!({"part":{"set":{"id":id,"pinned":shift[0] > 0.0}}})),
                8 => self.decide(&json!({"part":{"set":{"id":id,"visible":shift[0] > 0.0,"importance":2.0}}})),
                9..=10 => {
                    let pose = json!({"rotation":[turn.x,turn.y,turn.z,0.8],"translation":shift});
                    self.decide(&json!({"part":{"move":{"id":id,"pose":pose}}}));
                    let held = self.document.state().unwrap().scene.explosion.part(burin::explode::PartId(id));
                    let held = held.unwrap().held.unwrap();
                    assert!(self.poses().contains(&held), "{:#?}", self.trace);
                }
                11..=13 => self.move_parts(),
                14..=15 => self.travel("undo"),
                16 => self.travel("redo"),
                17 if self.group.is_none() => {
                    self.say(&json!({"history":{"begin":{}}}));
                    self.group = Some((undone(&self.document), false));
                }
                17 => {
                    self.say(&json!({"history":{"end":{}}}));
                    self.end_group();
                }
                18 if self.group.is_some() => {
                    let (begun, _) = self.group.take().unwrap();
                    let (before, pushed, stood) = (undone(&self.document), self.pushed(), self.poses());
                    self.say(&json!({"history":{"cancel":{}}}));
                    let found = undone(&self.document);
                    self.assert_same(&found, &begun, "cancel");
                    if found.1 != before.1 {
                        self.left.insert(pushed, stood);
                        self.assert_same(&self.poses(), &self.left[&self.pushed()], "poses");
                    }
                }
                19 => {
                    let told = (undone(&self.document), self.poses());
                    self.say(&json!({"project":{"save":{}}}));
                    if self.rng.random_range(0..2) == 0 {
                        // Whatever is done after that and not saved is gone.
                        self.decide(&json!({"explosion":{"degree":{"value":0.9}}}));
                        self.settle();
                        self.reopen(true);
                        let found = (undone(&self.document), self.poses());
                        self.assert_same(&found, &told, "save");
                    }
                }
                20..=21 => {
                    self.settle();
                    self.crash();
                }
                _ => {}
            }
        }
    }
}

#[test]
fn what_is_decided_and_what_is_found_come_back_whatever_was_done_between() {
    let dir = tempfile::tempdir().unwrap();
    let walks = std::env::var("BURIN_WALKS").map_or(4, |n| n.parse().unwrap());
    for seed in 0..walks {
        Walk::new(seed, dir.path()).go(40);
    }
}

#[test]
fn what_undo_has_forgotten_stands_at_rest_or_where_it_is() {
    let dir = tempfile::tempdir().unwrap();
    let mut walk = Walk::new(99, dir.path());
    let cut = |normal: [i32; 3]| json!({"part":{"split":{"by":{"plane":{"point":[0,5,0],"normal":normal}}}}});
    walk.say(&cut([1, 0, 0]));
    walk.say(&json!({"explosion":{"degree":{"value":1}}}));
    walk.settle();
    let apart = walk.poses();
    assert!(apart.iter().all(|pose| *pose != Pose::IDENTITY));
    // Far more than is remembered.
    for seed in 1..300 {
        walk.say(&json!({"explosion":{"seed":{"value":seed}}}));
    }
    walk.say(&json!({"history":{"undo":{"steps":299}}}));
    assert_eq!(walk.poses(), apart);
    walk.say(&json!({"history":{"undo":{}}}));
    assert!(walk.poses().iter().all(|pose| *pose == Pose::IDENTITY) && !walk.document.must_move());
    walk.say(&json!({"history":{"undo":{}}}));
    assert_eq!(walk.poses(), [Pose::IDENTITY]);
}
