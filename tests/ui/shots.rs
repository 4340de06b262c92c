use super::window::Window;
use burin::document::ViewName;
use burin::ui::*;

#[test]
fn shots() {
    for (w, h) in [(1280.0, 800.0), (2560.0, 1440.0)] {
        let mut window = Window::open([w, h]);
        for view in [ViewName::ThreeD, ViewName::Axial, ViewName::Coronal, ViewName::Sagittal] {
            let size = [64, 64];
            let rgba = (0..64 * 64).flat_map(|i| { let g = (((i % 64) as i32 - 32).pow(2) + ((i / 64) as i32 - 32).pow(2)) as u32; let v = if g < 700 { 200 - (g / 8) as u8 } else { 0 }; [v, v, v, 255] }).collect();
            let cam = window.scene.views.camera;
            window.report(Report::Picture(Box::new(Picture { view, size, rgba, depth_mm: vec![], object: vec![], camera: cam })));
        }
        window.click("Brush");
        window.harness.hover_at(egui::pos2(w * 0.62, h * 0.3));
        window.harness.run_steps(4);
        window.harness.render().unwrap().save(format!("/tmp/log/ui_shot_{w}.png")).unwrap();
        window.click("Keys");
        window.harness.render().unwrap().save(format!("/tmp/log/ui_keys_{w}.png")).unwrap();
    }
    let mut window = Window::empty([1280.0, 800.0]);
    window.report(Report::Message(Gravity::Error, "/data/x.nii: header field dim[1]: -3 found, 1 to 32767 expected".into()));
    window.harness.render().unwrap().save("/tmp/log/ui_empty.png").unwrap();
}
