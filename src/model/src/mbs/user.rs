//! User models: parameters of the user's own functions. The equations do not
//! depend on them.

use super::fields::{ElementFields, Messages, content};
use super::number::number;
use crate::{Model, UserModel};
use robovec_ir::diagnostic::clip;

pub(super) fn read(root: &ElementFields<'_>, model: &mut Model, messages: &mut Messages) {
    let Some(models) = root.one("user_models") else {
        return;
    };
    for node in ElementFields::of(models, &[], &["user_model"], messages).all() {
        let fields = ElementFields::of(node, &["name"], &["parameter"], messages);
        let name = fields.name("name", "a user model", messages);
        let parameters = fields
            .many("parameter")
            .map(|node| {
                let one = ["name", "type", "structure", "header"];
                let fields = ElementFields::of(node, &one, &["value"], messages);
                let owner = format!("a parameter of user model '{}'", clip(&name));
                let parameter = fields.name("name", &owner, messages);
                let owner = format!(
                    "parameter '{}' of user model '{}'",
                    clip(&parameter),
                    clip(&name)
                );
                let kind = fields.one("type").map(content).unwrap_or_default();
                let values = fields
                    .many("value")
                    .map(|value| number(value, &owner, messages))
                    .collect();
                (parameter, kind, values)
            })
            .collect();
        model.user_models.push(UserModel { name, parameters });
    }
}
