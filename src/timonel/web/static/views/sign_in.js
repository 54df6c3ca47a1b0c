// @ts-check
/** Where the gateway wants a token before it shows anything. */

import {html, setText} from "../dom.js";
import {t} from "../i18n.js";
import {signIn} from "../session.js";

/** @param {() => void} done */
export function signInPage(done) {
  const token = html("input", {id: "token", type: "password", autocomplete: "current-password", required: true, maxlength: 200});
  const wrong = html("p", {class: "wrong", role: "alert"});
  const form = html("form", {class: "panel sign-in"}, html("h1", {}, "timonel"), html("label", {for: "token"}, t("sign_in.token")), token,
    html("button", {class: "key main", type: "submit"}, t("sign_in.enter")), wrong);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const outcome = await signIn(token.value);
    if (outcome.ok) done();
    else setText(wrong, outcome.error || t("link.lost"));
  });
  return html("main", {class: "sign-in-page"}, form);
}
