//! Camera options, named as in f3d.
//!
//! Without a position the whole scene is framed from a direction (a named view, `--camera-direction`, or
//! three-quarter from above); with one the camera stands there and looks at the focal point, by default the scene's
//! center. Azimuth and elevation turn what results about the focal point. Positions are in the file's coordinates.

use clap::Args;
use glam::DVec3;

use super::failure::{Exit, Failure};
use crate::math::views::{VIEW_ANGLE, VIEWS, ZOOM_FACTOR};
use crate::math::{Bounds, Camera, Projection};
use crate::scene::{Scene, SceneCamera};

/// Options for the camera.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// A view (front, back, left, right, top, bottom, isometric, three-quarter) or a camera of the file, by name or
    /// number
    #[arg(long, value_name = "NAME", conflicts_with_all = ["camera_direction", "camera_position", "camera_focal_point"])]
    pub camera: Option<String>,
    /// Where the eye is, in the file's coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, conflicts_with = "camera_direction")]
    pub camera_position: Option<DVec3>,
    /// The point looked at [default: the center of the model]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub camera_focal_point: Option<DVec3>,
    /// The direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    pub camera_view_up: Option<DVec3>,
    /// Vertical angle of view in degrees [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = view_angle)]
    pub camera_view_angle: Option<f64>,
    /// The direction that the camera looks along
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    pub camera_direction: Option<DVec3>,
    /// Turns the eye about the focal point to its right
    #[arg(long, value_name = "DEGREES", value_parser = number, allow_hyphen_values = true)]
    pub camera_azimuth_angle: Option<f64>,
    /// Turns the eye about the focal point upwards
    #[arg(long, value_name = "DEGREES", value_parser = number, allow_hyphen_values = true)]
    pub camera_elevation_angle: Option<f64>,
    /// How much of the picture the box around the model fills [default: 0.9]
    #[arg(long, value_name = "FACTOR", value_parser = positive, conflicts_with = "camera_position")]
    pub camera_zoom_factor: Option<f64>,
    /// Parallel projection
    #[arg(long)]
    pub orthographic: bool,
}

impl CameraArgs {
    /// What the options ask for, in words.
    pub fn describe(&self) -> String {
        let plain = CameraArgs { camera: self.camera.clone(), ..CameraArgs::default() };
        match &self.camera {
            _ if format!("{plain:?}") != format!("{self:?}") => "a camera of its own".to_owned(),
            Some(name) => format!("camera {name}"),
            None => "three-quarter view".to_owned(),
        }
    }

    /// The camera for a scene in a picture of `aspect` = width / height.
    ///
    /// # Errors
    /// [`Exit::Usage`] if no view or camera has the name, or directions contradict each other.
    pub fn camera(&self, scene: &Scene, aspect: f64) -> Result<Camera, Failure> {
        self.camera_around(scene, &scene.bounds(), aspect)
    }

    /// The camera for a scene whose parts lie in `bounds`, as an arrangement may have put them.
    ///
    /// # Errors
    /// As [`CameraArgs::camera`].
    pub fn camera_around(&self, scene: &Scene, bounds: &Bounds, aspect: f64) -> Result<Camera, Failure> {
        let camera = match (&self.camera, self.camera_position) {
            (Some(name), _) => match VIEWS.iter().find(|(view, ..)| view == name) {
                Some(&(_, direction, up)) => self.framed(scene, bounds, aspect, direction, up),
                None => self.of_file(scene, bounds, name)?,
            },
            (None, Some(position)) => self.placed(scene, bounds, position - scene.origin),
            (None, None) => {
                let (_, usual, up) = VIEWS[VIEWS.len() - 1];
                let direction = self.camera_direction.unwrap_or(usual).normalize();
                // Straight up or down, y is no up.
                let up = if direction.cross(up).length() < 1e-6 { DVec3::NEG_Z * -direction.y.signum() } else { up };
                self.framed(scene, bounds, aspect, direction, up)
            }
        };
        let toward = camera.focal_point - camera.position;
        if toward.length() == 0.0 || !toward.is_finite() {
            return Err(Failure::new(Exit::Usage, "the camera's position and focal point coincide"));
        }
        if camera.view_up.normalize().cross(camera.direction()).length() < 1e-9 {
            return Err(Failure::new(Exit::Usage, "the camera looks along its own view-up direction"));
        }
        Ok(self.turned(camera))
    }

    /// Whether any option says something.
    pub fn is_given(&self) -> bool {
        format!("{self:?}") != format!("{:?}", CameraArgs::default())
    }

    /// Whether the options only turn a camera that is there.
    pub fn only_turns(&self) -> bool {
        let plain = CameraArgs { camera_azimuth_angle: None, camera_elevation_angle: None, ..self.clone() };
        self.is_given() && !plain.is_given()
    }

    /// The camera turned by azimuth and elevation.
    pub fn turned(&self, mut camera: Camera) -> Camera {
        if let Some(degrees) = self.camera_azimuth_angle {
            camera = camera.azimuth(degrees);
        }
        if let Some(degrees) = self.camera_elevation_angle {
            camera = camera.elevation(degrees);
        }
        camera
    }

    fn fov(&self) -> f64 {
        self.camera_view_angle.unwrap_or(VIEW_ANGLE).to_radians()
    }

    fn framed(&self, scene: &Scene, bounds: &Bounds, aspect: f64, direction: DVec3, up: DVec3) -> Camera {
        let up = self.camera_view_up.unwrap_or(up);
        let zoom = self.camera_zoom_factor.unwrap_or(ZOOM_FACTOR);
        let mut camera = Camera::framing(bounds, direction, up, aspect, zoom, self.orthographic, self.fov());
        if let Some(focal) = self.camera_focal_point {
            let shift = focal - scene.origin - camera.focal_point;
            camera.position += shift;
            camera.focal_point += shift;
        }
        camera
    }

    fn placed(&self, scene: &Scene, bounds: &Bounds, position: DVec3) -> Camera {
        let focal_point = self.camera_focal_point.map_or_else(|| bounds.center(), |p| p - scene.origin);
        let toward = (focal_point - position).normalize_or_zero();
        let up =
            self.camera_view_up.unwrap_or(if toward.cross(DVec3::Y).length() < 1e-6 { DVec3::NEG_Z } else { DVec3::Y });
        let projection = Projection::Perspective { fov_y: self.fov() };
        self.projected(Camera { position, focal_point, view_up: up, projection })
    }

    fn of_file(&self, scene: &Scene, bounds: &Bounds, name: &str) -> Result<Camera, Failure> {
        let named = scene.cameras.iter().find(|c| c.name == name);
        let numbered = || name.parse::<usize>().ok().and_then(|i| scene.cameras.get(i));
        let Some(SceneCamera { world_from_camera, projection, .. }) = named.or_else(numbered) else {
            let views = VIEWS.iter().map(|(view, ..)| (*view).to_owned());
            let cameras = scene.cameras.iter().enumerate().map(|(i, c)| format!("{i} '{}'", c.name));
            let all: Vec<String> = views.chain(cameras).collect();
            return Err(Failure::new(
                Exit::Usage,
                format!("no camera is called '{name}'; there are {}", all.join(", ")),
            ));
        };
        let position = world_from_camera.transform_point3(DVec3::ZERO);
        let forward = world_from_camera.transform_vector3(DVec3::NEG_Z).normalize_or(DVec3::NEG_Z);
        let sphere = bounds.bounding_sphere();
        // A file does not say how far it looks: to the depth of the scene's center, if that lies ahead.
        let ahead = (sphere.center - position).dot(forward);
        let distance = [ahead, sphere.radius, 1.0].into_iter().find(|&d| d > 0.0).unwrap_or(1.0);
        let up = world_from_camera.transform_vector3(DVec3::Y).normalize_or(DVec3::Y);
        let mut camera = Camera {
            position,
            focal_point: position + forward * distance,
            view_up: self.camera_view_up.unwrap_or(up),
            projection: *projection,
        };
        if let (Some(_), Projection::Perspective { .. }) = (self.camera_view_angle, camera.projection) {
            camera.projection = Projection::Perspective { fov_y: self.fov() };
        }
        if let Some(zoom) = self.camera_zoom_factor {
            // There is nothing to frame; a factor beside the default one enlarges about the middle.
            camera.projection = match camera.projection {
                Projection::Perspective { fov_y } => {
                    Projection::Perspective { fov_y: 2.0 * ((fov_y * 0.5).tan() / zoom).atan() }
                }
                Projection::Orthographic { height } => Projection::Orthographic { height: height / zoom },
            };
        }
        Ok(self.projected(camera))
    }

    /// The camera made parallel if asked for, with the same picture at its focal point.
    fn projected(&self, mut camera: Camera) -> Camera {
        if self.orthographic {
            camera.projection = Projection::Orthographic { height: camera.visible_height() };
        }
        camera
    }
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| "expected a number".to_owned())
}

/// Parses a number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|&v| v > 0.0).ok_or_else(|| "expected a number greater than 0".to_owned())
}

fn view_angle(text: &str) -> Result<f64, String> {
    let inside = |v: &f64| *v >= 0.001 && *v < 180.0;
    number(text).ok().filter(inside).ok_or_else(|| "expected degrees from 0.001 to less than 180".to_owned())
}

fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(number).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => Err("expected three numbers, as in 1,-2.5,0".to_owned()),
    }
}

fn direction(text: &str) -> Result<DVec3, String> {
    point(text)?.try_normalize().ok_or_else(|| "expected a direction: not all of it zero".to_owned())
}

#[cfg(test)]
mod tests {
    use glam::DMat4;

    use super::*;
    use crate::scene::Part;

    /// A box from (−1, −1, −1) to (1, 1, 1), re-based by (100, 0, 0).
    fn scene() -> Scene {
        let part = Part {
            name: String::new(),
            node: 0,
            mesh: 0,
            world_from_part: DMat4::IDENTITY,
            first_triangle: 0,
            triangle_count: 1,
            bounds: Bounds::of_points([DVec3::NEG_ONE, DVec3::ONE]),
        };
        let world_from_camera = DMat4::from_translation(DVec3::new(0.0, 0.0, 4.0));
        let eye = SceneCamera {
            name: "eye".to_owned(),
            world_from_camera,
            projection: Projection::Perspective { fov_y: 1.0 },
        };
        Scene { parts: vec![part], origin: DVec3::new(100.0, 0.0, 0.0), cameras: vec![eye], ..Scene::default() }
    }

    fn camera(line: &str) -> Result<Camera, Failure> {
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            camera: CameraArgs,
        }
        let words = std::iter::once("test").chain(line.split_whitespace());
        let line = <Line as clap::Parser>::try_parse_from(words).map_err(|e| Failure::new(Exit::Usage, e))?;
        line.camera.camera(&scene(), 1.0)
    }

    fn close(a: DVec3, b: DVec3) -> bool {
        (a - b).length() < 1e-5
    }

    #[test]
    fn named_views_look_where_their_names_say() {
        for (name, eye, up) in [
            ("front", DVec3::Z, DVec3::Y),
            ("back", DVec3::NEG_Z, DVec3::Y),
            ("left", DVec3::NEG_X, DVec3::Y),
            ("right", DVec3::X, DVec3::Y),
            ("top", DVec3::Y, DVec3::NEG_Z),
            ("bottom", DVec3::NEG_Y, DVec3::Z),
            ("isometric", DVec3::ONE, DVec3::Y),
        ] {
            let c = camera(&format!("--camera {name}")).unwrap();
            assert!(close(-c.direction(), eye.normalize()), "{name}: {:?}", c.direction());
            assert!(close(c.view_up, up) && close(c.focal_point, DVec3::ZERO));
        }
        let turned = camera("--camera front --camera-azimuth-angle 35 --camera-elevation-angle 25").unwrap();
        assert!(close(turned.direction(), camera("").unwrap().direction()), "the default is three-quarter");
    }

    #[test]
    fn framing_follows_zoom_angle_and_projection() {
        let c = camera("--camera front --camera-zoom-factor 1 --camera-view-angle 60").unwrap();
        // The near face, 1 in front of the middle, touches the picture's edge.
        assert!((c.distance() - (3.0_f64.sqrt() + 1.0)).abs() < 1e-9);
        let near = camera("--camera front --camera-zoom-factor 2 --camera-view-angle 60").unwrap();
        assert!(((c.distance() - 1.0) / (near.distance() - 1.0) - 2.0).abs() < 1e-9);
        let flat = camera("--camera front --orthographic --camera-zoom-factor 1").unwrap();
        assert!((flat.visible_height() - 2.0).abs() < 1e-9);
    }

    #[test]
    fn positions_are_in_the_files_coordinates() {
        let c = camera("--camera-position 100,0,5").unwrap();
        assert!(close(c.position, DVec3::new(0.0, 0.0, 5.0)) && close(c.focal_point, DVec3::ZERO));
        let c = camera("--camera-position 100,0,5 --camera-focal-point 101,0,0 --camera-view-up -1,0,0").unwrap();
        assert!(close(c.focal_point, DVec3::X) && close(c.view_up, DVec3::NEG_X));
        let c = camera("--camera-direction 0,0,-1 --camera-focal-point 101,0,0").unwrap();
        assert!(close(c.direction(), DVec3::NEG_Z) && close(c.focal_point, DVec3::X));
        let flat = camera("--camera-position 100,0,5 --orthographic").unwrap();
        assert!((flat.visible_height() - 2.0 * 15_f64.to_radians().tan() * 5.0).abs() < 1e-9);
        for straight in ["--camera-direction 0,-1,0", "--camera-direction 0,2,0", "--camera-position 100,9,0"] {
            camera(straight).unwrap_or_else(|e| panic!("{straight}: {e:?}"));
        }
    }

    #[test]
    fn cameras_of_the_file_are_found_by_name_and_number() {
        for name in ["eye", "0"] {
            let c = camera(&format!("--camera {name}")).unwrap();
            assert!(close(c.position, DVec3::new(0.0, 0.0, 4.0)) && close(c.focal_point, DVec3::ZERO), "{c:?}");
            assert_eq!(c.projection, Projection::Perspective { fov_y: 1.0 });
        }
        let zoomed = camera("--camera eye --camera-zoom-factor 2").unwrap();
        assert!((camera("--camera eye").unwrap().visible_height() / zoomed.visible_height() - 2.0).abs() < 1e-9);
        let missing = camera("--camera nose").unwrap_err();
        assert!(missing.message.contains("isometric") && missing.message.contains("0 'eye'"), "{missing:?}");
    }

    #[test]
    fn nonsense_is_a_usage_error() {
        for line in [
            "--camera-position 1,2",
            "--camera-position 1,2,x",
            "--camera-position 1,2,inf",
            "--camera-direction 0,0,0",
            "--camera-view-angle 0",
            "--camera-view-angle 180",
            "--camera-zoom-factor 0",
            "--camera-zoom-factor -1",
            "--camera-azimuth-angle NaN",
            "--camera front --camera-direction 1,0,0",
            "--camera-position 1,2,3 --camera-direction 1,0,0",
            "--camera-position 100,0,0",
            "--camera front --camera-view-up 0,0,1",
        ] {
            assert_eq!(camera(line).map_err(|f| f.exit), Err(Exit::Usage), "{line}");
        }
    }
}
