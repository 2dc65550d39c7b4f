//! What a scene occupies, and the defaults that follow from it.

use glam::DVec3;

use super::{HeightSource, Mesh, Primitive, Scene, camera, light};

impl Scene {
    /// The lowest and highest corner, in world space, of everything drawn: base surfaces and all that their
    /// displacement can reach. Nothing where nothing is drawn.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        // Height maps are scanned once, however often their mesh is instanced.
        let ranges = |mesh: &Mesh| mesh.primitives.iter().map(|p| self.displacement_range(p)).collect();
        let ranges: Vec<Vec<_>> = self.meshes.iter().map(ranges).collect();
        let mut bounds: Option<(DVec3, DVec3)> = None;
        for instance in &self.instances {
            let mesh = &self.meshes[instance.mesh];
            for (primitive, &(low, high)) in mesh.primitives.iter().zip(&ranges[instance.mesh]) {
                for &vertex in primitive.triangles.iter().flatten() {
                    let position = primitive.positions[vertex as usize].as_dvec3();
                    let normal = mesh.shell_normals[primitive.weld[vertex as usize] as usize];
                    // The shell map is affine in t and in λ, so its corners bound it.
                    for t in [low, 0.0, high] {
                        let point = instance.transform.transform_point3(position + t * normal);
                        let (a, b) = bounds.unwrap_or((point, point));
                        bounds = Some((a.min(point), b.max(point)));
                    }
                }
            }
        }
        bounds
    }

    /// The lowest and highest `t` of a primitive's surface over all of its height field: `(h - midlevel) · scale`. Both
    /// are zero for a plain surface.
    pub fn displacement_range(&self, primitive: &Primitive) -> (f64, f64) {
        match &self.materials[primitive.material].displacement {
            Some(displacement) => {
                let (low, high) = match displacement.source {
                    HeightSource::Map(map) => self.height_maps[map].min_max(),
                    HeightSource::Procedure(procedure) => procedure.extent().into(),
                };
                let t = |height: f64| (height - displacement.midlevel) * primitive.displacement_scale;
                (t(low), t(high))
            }
            None => (0.0, 0.0),
        }
    }

    /// Adds what the file lacks and a picture needs, with a notice for each: a camera that frames the scene in the
    /// given aspect ratio (width by height), and a directional light. [`super::load`] adds neither.
    pub fn with_defaults(mut self, aspect: f64) -> Scene {
        if self.camera.is_none() {
            self.camera = Some(camera::frame(self.bounds().unwrap_or_default(), aspect));
            self.notices.push("no camera in the file: one that frames the scene was added".to_owned());
        }
        if self.lights.is_empty() {
            self.lights.push(light::default_light());
            self.notices.push("no light in the file: one directional light was added".to_owned());
        }
        self
    }
}
