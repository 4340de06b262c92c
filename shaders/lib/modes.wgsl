#define_import_path burin::modes
// Bodies of several modes in one picture: each body's samples are its own mode's.
//
// Bodies of direct volume rendering are composed sample by sample. An iso-surface is one sample of its look's opacity at the hit, a
// maximum one sample at the end of the body's span: `merge` finds and orders them. Where samples stand for stretches (REFINE) those
// of bodies of direct volume rendering do.

#import burin::constants::{MODE_DVR, MODE_ISO, MODE_MIP}
#import burin::body::{Ray, BodyRay, body_mode, sample_after}
#import burin::picture::Picture
#import burin::span::Run
#import burin::dvr
#import burin::iso
#import burin::mip

const RUN: f32 = 32.0;

fn begin(before: Picture) -> bool {
    return dvr::begin(before);
}

// Every sample is asked of a maximum.
fn meet(r: BodyRay, run: Run, k: f32, texel: f32) -> vec4<f32> {
    let mode = body_mode();
    if (mode == MODE_ISO) {
        return iso::meet(r, run, k, texel);
    }
    if (mode == MODE_MIP) {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    return dvr::meet(r, run, k, texel);
}

#ifdef REFINE
fn after(k: f32) -> f32 {
    return select(sample_after(k), dvr::after(k), body_mode() == MODE_DVR);
}

fn open(r: BodyRay, k: f32) {
    if (body_mode() == MODE_DVR) {
        dvr::open(r, k);
    }
}

fn inside() -> bool {
    return body_mode() == MODE_DVR && dvr::inside();
}
#else
fn after(k: f32) -> f32 {
    return sample_after(k);
}

fn open(r: BodyRay, k: f32) {}

fn inside() -> bool {
    return false;
}
#endif

fn add(r: BodyRay, run: Run, k: f32, texel: f32, c: vec4<f32>) {
    let mode = body_mode();
    if (mode == MODE_ISO) {
        iso::add(r, run, k, texel, c);
    } else if (mode == MODE_MIP) {
        mip::add(r, run, k, texel, c);
    } else {
        dvr::add(r, run, k, texel, c);
    }
}

fn done() -> bool {
    let mode = body_mode();
    if (mode == MODE_ISO) {
        return iso::done();
    }
    return mode != MODE_MIP && dvr::done();
}

fn end(before: Picture, ray: Ray) -> Picture {
    return dvr::end(before, ray);
}
