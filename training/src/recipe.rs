//! Recipes: the stages of a predictor and their settings, one file each.

use models::FeatureSet;
use serde::{Deserialize, Serialize};

use crate::TrainingError;
use crate::network::NetworkRecipe;
use crate::staged::StagedRecipe;

/// Built-in recipes: name and text.
const BUILTIN: [(&str, &str); 7] = [
    ("staged", include_str!("../recipes/staged.toml")),
    ("linear", include_str!("../recipes/linear.toml")),
    ("lstm", include_str!("../recipes/lstm.toml")),
    ("lstm-paper", include_str!("../recipes/lstm-paper.toml")),
    ("gru", include_str!("../recipes/gru.toml")),
    ("gru-paper", include_str!("../recipes/gru-paper.toml")),
    ("narx", include_str!("../recipes/narx.toml")),
];

/// The stages of a predictor. With both, the network is trained on the residual of the staged
/// predictor and kept only if it lowers the held-out error. A network alone is trained on the
/// tracking error from the papers' features.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    /// Least squares: linear law, friction, position harmonics.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub staged: Option<StagedRecipe>,
    /// A network.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub network: Option<NetworkRecipe>,
}

impl Recipe {
    /// Names of the built-in recipes: `staged` (grey-box cascade, the usual choice), `linear`, and Paper D's networks `lstm`, `lstm-paper`,
    /// `gru`, `gru-paper`, `narx`.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|(name, _)| *name)
    }

    /// The built-in recipe of that name, one of [`Recipe::names`].
    ///
    /// # Errors
    /// When there is none.
    pub fn builtin(name: &str) -> Result<Self, TrainingError> {
        let found = BUILTIN.iter().find(|(known, _)| *known == name);
        let (_, text) = found.ok_or_else(|| {
            let names: Vec<&str> = Self::names().collect();
            TrainingError::Recipe(format!("there is no predictor `{name}`; there are {}", names.join(", ")))
        })?;
        Self::from_toml(text)
    }

    /// Parses the text of a recipe file.
    ///
    /// # Errors
    /// When the text is no recipe or a setting is invalid; the message has the line or the setting.
    pub fn from_toml(text: &str) -> Result<Self, TrainingError> {
        let recipe: Self = toml::from_str(text).map_err(|error| TrainingError::Recipe(error.to_string()))?;
        if recipe.staged.is_none() && recipe.network.is_none() {
            return Err(TrainingError::Recipe("a recipe needs a section [staged] or [network]".into()));
        }
        recipe.network.iter().try_for_each(NetworkRecipe::check)?;
        Ok(recipe)
    }

    /// The same recipe with these features, if it has a network only.
    #[must_use]
    pub fn with_features(mut self, features: FeatureSet) -> Self {
        if self.staged.is_none()
            && let Some(network) = &mut self.network
        {
            network.features = features;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::NetworkKind;

    #[test]
    fn every_recipe_equals_the_defaults_of_the_library() {
        let alone = |network| Recipe { staged: None, network: Some(network) };
        let linear = StagedRecipe { stop_half_widths: Vec::new(), ..StagedRecipe::default() };
        for (name, recipe) in [
            ("staged", Recipe { staged: Some(StagedRecipe::default()), network: Some(NetworkRecipe::residual()) }),
            ("linear", Recipe { staged: Some(linear), network: None }),
            ("lstm", alone(NetworkRecipe::quick(NetworkKind::Lstm))),
            ("lstm-paper", alone(NetworkRecipe::paper(NetworkKind::Lstm))),
            ("gru", alone(NetworkRecipe::quick(NetworkKind::Gru))),
            ("gru-paper", alone(NetworkRecipe::paper(NetworkKind::Gru))),
            ("narx", alone(NetworkRecipe::quick(NetworkKind::Narx))),
        ] {
            assert_eq!(Recipe::builtin(name).unwrap(), recipe, "{name}:\n{}", toml::to_string(&recipe).unwrap());
        }
        assert_eq!(Recipe::names().count(), 7);
    }

    #[test]
    fn keys_of_earlier_versions_are_read() {
        let with_keys = |speeds: &str, half_width: &str, passes: &str, harmonics: &str| {
            let text =
                format!("[staged]\n{speeds} = [0.2]\n{half_width} = 0.004\n{passes} = 2\n[staged.{harmonics}]\nat_most = 3\n");
            Recipe::from_toml(&text).unwrap()
        };
        let old = with_keys("drag_speeds", "play_half_width", "play_passes", "lines");
        assert_eq!(old, with_keys("viscous_speeds", "backlash_half_width", "backlash_passes", "harmonics"));
        let staged = old.staged.unwrap();
        assert_eq!((staged.viscous_speeds, staged.backlash_half_width, staged.backlash_passes), (vec![0.2], 0.004, 2));
        assert_eq!(staged.harmonics.at_most, 3);
    }

    #[test]
    fn invalid_recipes_are_refused_with_the_reason() {
        let error = |text: &str| Recipe::from_toml(text).unwrap_err().to_string();
        assert!(error("").contains("[staged]"));
        assert!(error("[staged]\nfoldz = 3\n").contains("foldz"));
        let text = toml::to_string(&Recipe::builtin("lstm").unwrap()).unwrap();
        assert!(error(&text.replace("hidden = 64", "hidden = 0")).contains("hidden"));
        assert!(Recipe::builtin("crystal-ball").unwrap_err().to_string().contains("narx"));
    }
}
